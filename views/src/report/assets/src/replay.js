// The 3D replay: the stage, the robot, what the tasks see, and the switches for them. When its place
// scrolls out of the window, the picture moves to a corner, so that it can be seen beside the plots.

import { Box3, Vector3 } from 'three';
import { h } from './dom.js';
import { createLabels } from './labels.js';
import { createObstacles, createPlanes, createPoints, createTargets, createTraces, createTruePlaces, createVolumes } from './overlays.js';
import { createPeople, near } from './people.js';
import { createPoses } from './poses.js';
import { createRobot } from './robot.js';
import { createStage } from './stage.js';

const NO_WEBGL = 'The 3D replay needs WebGL, which this browser does not offer. Tables and plots are complete without it.';
const ON_PAPER = 'The 3D replay needs WebGL and a screen: open this file in a browser.';

// How far from the robot people are held by the camera too, in m.
const BESIDE = 1.5;

// Where the links go during the whole run, sampled, and people beside them; the camera holds all of it.
function reach(robot, poses, people, scene, t0) {
  const box = new Box3();
  robot.groups.forEach((g, k) => poses.place(g, k, t0));
  scene.updateMatrixWorld(true);
  robot.groups.forEach((g) => box.expandByObject(g, true));
  const point = new Vector3();
  const step = Math.max(1, Math.floor(poses.frames / 50));
  for (let i = 0; i < poses.frames; i += step) {
    robot.groups.forEach((_, k) => {
      poses.point(i, k, [0, 0, 0], point).applyMatrix4(scene.matrixWorld);
      if (Number.isFinite(point.x + point.y + point.z)) box.expandByPoint(point);
    });
  }
  near(people, box.clone(), BESIDE, box);
  if (box.isEmpty()) box.expandByPoint(point.set(-0.5, -0.5, 0)).expandByPoint(point.set(0.5, 0.5, 1));
  return box;
}

/** Returns `{ node, recolor, print(on) }`; the node holds a plain sentence if 3D is not possible. */
export function createReplay(data, clock) {
  const sentence = (text) => ({ node: h('section', { class: 'replay' }, h('p', { class: 'replay-missing' }, text)), recolor() {}, print() {} });
  if (data.scene.poses.frames === 0) return sentence('No poses were recorded for the 3D replay.');
  let stage;
  try {
    stage = createStage(data.scene.up);
  } catch {
    return sentence(NO_WEBGL);
  }
  const { links, poses: recorded, planes, points, keepOut, obstacles, people, targets, traces } = data.scene;
  const poses = createPoses(recorded.times, recorded.data, links.length, recorded.stride);
  const robot = createRobot(links);
  stage.scene.add(...robot.groups);
  stage.frame(reach(robot, poses, people, stage.scene, recorded.times[0]));

  const parts = {
    Points: createPoints(points, robot.groups),
    Volumes: createVolumes(keepOut, robot.groups),
    Walls: createPlanes(planes, stage.scene),
    Obstacles: createObstacles(obstacles, recorded.times, robot.groups, stage.scene),
    'True places': createTruePlaces(obstacles, robot.groups, stage.scene),
    People: createPeople(people, recorded.times, stage.scene),
    Targets: createTargets(targets, recorded.times, stage.scene),
    Traces: createTraces(traces, poses, stage.scene),
  };
  const on = Object.fromEntries(Object.keys(parts).map((k) => [k, true]));
  const labels = createLabels(Object.values(parts).flatMap((p) => p.nodes));
  stage.onDraw(labels.update);

  function show() {
    robot.groups.forEach((g, k) => { g.visible = poses.place(g, k, clock.time); });
    parts.Targets.show(clock.time, on.Targets);
    parts.Obstacles.show(clock.time, on.Obstacles);
    parts.People.show(clock.time, on.People);
    parts.Traces.show(clock.time);
    stage.request();
  }
  function chip(name, state, flip) {
    const button = h('button', { type: 'button', class: 'chip', 'aria-pressed': String(state), onclick: () => button.setAttribute('aria-pressed', String(flip())) }, name);
    return button;
  }
  const chips = Object.entries(parts).filter(([, p]) => p.nodes.length > 0).map(([name, part]) => chip(name, true, () => {
    on[name] = !on[name];
    part.nodes.forEach((n) => { n.node.visible = on[name]; });
    show();
    return on[name];
  }));
  if (Object.values(parts).some((p) => p.nodes.length > 0)) {
    chips.push(chip('Names', false, () => { labels.layer.hidden = !labels.layer.hidden; stage.request(); return !labels.layer.hidden; }));
  }
  const views = stage.views.map((name) => h('button', { type: 'button', class: 'view', onclick: () => stage.look(name) }, name));

  const close = h('button', { type: 'button', class: 'undock', title: 'Close the small picture', 'aria-label': 'Close the small picture', onclick: () => { allowed = false; dock(); } }, '✕');
  const picture = h('div', { class: 'picture' }, stage.renderer.domElement, labels.layer);
  const viewer = h('div', { class: 'viewer' },
    h('div', { class: 'viewer-bar viewer-top' }, h('div', { class: 'chips' }, chips), h('div', { class: 'views' }, views)), picture, close);
  const still = h('img', { class: 'still', alt: 'The robot at the shown time' });
  const node = h('section', { class: 'replay', 'aria-label': '3D replay' }, viewer, still, h('p', { class: 'on-paper' }, ON_PAPER));

  let allowed = true;
  let away = false;
  function dock() {
    viewer.classList.toggle('docked', away && allowed && matchMedia('(min-width: 900px)').matches);
  }
  new IntersectionObserver(([entry]) => {
    away = !entry.isIntersecting && entry.boundingClientRect.top < 0;
    if (!away) allowed = true;
    dock();
  }, { threshold: 0.12 }).observe(node);

  let framed = false;
  new ResizeObserver(() => {
    stage.resize(picture.clientWidth, picture.clientHeight);
    if (!framed && picture.clientWidth > 1) { framed = true; stage.look('Oblique'); }
  }).observe(picture);

  function recolor() {
    robot.recolor();
    Object.values(parts).forEach((p) => p.recolor());
    stage.recolor();
  }
  recolor();
  clock.on('time', show);
  show();
  return {
    node, recolor,
    /** On paper the picture is a still. */
    print(printing) {
      if (!printing) return;
      still.src = stage.still();
    },
  };
}

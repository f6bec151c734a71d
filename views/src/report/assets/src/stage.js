// Camera, light, floor and the drawing of a picture. A picture is drawn only when something changed.

import { Box3, Color, DirectionalLight, GridHelper, Group, HemisphereLight, Mesh, NeutralToneMapping, PCFShadowMap, PerspectiveCamera, PlaneGeometry, Scene, ShadowMaterial, Vector3, WebGLRenderer } from 'three';
import { OrbitControls } from 'three/addons/controls/OrbitControls.js';
import { cssVar } from './dom.js';

// Directions from which the robot is seen; x is its front.
const VIEWS = { Oblique: [1, -0.75, 0.45], Front: [1, 0, 0.05], Side: [0, -1, 0.05], Top: [0.001, 0, 1] };

const SLOW_MS = 55;
const SLOW_PICTURES = 4;
const MOVING_MS = 800;
const REST_MS = 500;

// Without a graphics processor a picture takes long. While things move, shadows and then resolution are
// given up; when they rest, the picture is drawn once more at its best.
function createPace(setLevel, draw) {
  let level = 0;
  let needed = 0;
  let slow = 0;
  let last = -Infinity;
  let timer = 0;
  const set = (next) => { if (next !== level) { level = next; setLevel(level); } };
  return {
    /** `wait`: ms between the wish for a picture and the moment the browser was ready to draw it. */
    picture(wait, now) {
      slow = wait > SLOW_MS ? slow + 1 : Math.max(0, slow - 1);
      if (slow >= SLOW_PICTURES && needed < 2) { needed += 1; slow = 0; }
      if (now - last < MOVING_MS) set(needed);
      last = now;
      clearTimeout(timer);
      if (level > 0) timer = setTimeout(() => { set(0); draw(); }, REST_MS);
    },
    best: () => set(0),
  };
}

/** Throws if the browser has no WebGL. */
export function createStage(up) {
  const renderer = new WebGLRenderer({ antialias: true, alpha: true });
  renderer.setPixelRatio(Math.min(2, devicePixelRatio));
  renderer.shadowMap.enabled = true;
  renderer.shadowMap.type = PCFShadowMap;
  renderer.toneMapping = NeutralToneMapping;
  const scene = new Group();
  const camera = new PerspectiveCamera(32, 1, 0.02, 200);
  // The world is drawn with z up; a scene with y up is turned by its root.
  camera.up.set(0, 0, 1);
  if (up === 'y') scene.rotation.x = Math.PI / 2;

  const sky = new HemisphereLight(0xffffff, 0x9a948c, 1.5);
  const sun = new DirectionalLight(0xffffff, 2.2);
  sun.castShadow = true;
  sun.shadow.mapSize.set(2048, 2048);
  sun.shadow.radius = 5;
  sun.shadow.bias = -0.0004;
  sun.shadow.normalBias = 0.02;
  const fill = new DirectionalLight(0xffffff, 0.5);
  const world = new Scene();
  world.add(scene, sky, sun, sun.target, fill);
  sky.position.set(0, 0, 1);

  const floor = new Mesh(new PlaneGeometry(40, 40), new ShadowMaterial({ opacity: 0.16 }));
  floor.receiveShadow = true;
  world.add(floor);
  let grids = [];

  const controls = new OrbitControls(camera, renderer.domElement);
  controls.enableDamping = false;
  controls.zoomSpeed = 0.8;
  // The wheel scrolls the page until the picture has been taken hold of.
  controls.enableZoom = false;
  renderer.domElement.addEventListener('pointerdown', () => { controls.enableZoom = true; });
  renderer.domElement.addEventListener('pointerleave', () => { controls.enableZoom = false; });

  const bounds = new Box3();
  const after = [];
  let size = [1, 1];
  let waiting = false;
  function draw() {
    renderer.render(world, camera);
    after.forEach((f) => f(camera, ...size));
  }
  const pace = createPace((level) => {
    sun.castShadow = level === 0;
    renderer.setPixelRatio([Math.min(2, devicePixelRatio), 1, 0.6][level]);
    renderer.setSize(...size, false);
  }, draw);
  function request() {
    if (waiting) return;
    waiting = true;
    const asked = performance.now();
    requestAnimationFrame(() => {
      waiting = false;
      const now = performance.now();
      pace.picture(now - asked, now);
      draw();
    });
  }
  controls.addEventListener('change', request);

  function look(name) {
    const center = bounds.getCenter(new Vector3());
    const radius = Math.max(0.2, bounds.getSize(new Vector3()).length() / 2);
    const half = (camera.fov * Math.PI) / 360;
    const narrow = Math.min(half, Math.atan(Math.tan(half) * camera.aspect));
    controls.target.copy(center);
    camera.position.copy(center).addScaledVector(new Vector3(...VIEWS[name]).normalize(), (radius / Math.sin(narrow)) * 0.92);
    camera.near = radius / 50;
    camera.far = radius * 60;
    camera.updateProjectionMatrix();
    controls.update();
    request();
  }

  function recolor() {
    grids.forEach((g) => { world.remove(g); g.dispose(); });
    const extent = Math.max(4, 2 * Math.ceil(bounds.isEmpty() ? 2 : bounds.getSize(new Vector3()).length()));
    const fine = new GridHelper(extent, extent * 4, cssVar('--scene-grid'), cssVar('--scene-grid'));
    const coarse = new GridHelper(extent, extent, cssVar('--scene-grid-strong'), cssVar('--scene-grid-strong'));
    grids = [fine, coarse];
    grids.forEach((g) => { g.rotation.x = Math.PI / 2; g.position.z = -0.001; g.material.transparent = true; g.material.depthWrite = false; world.add(g); });
    coarse.position.z = -0.0005;
    sky.groundColor = new Color(cssVar('--scene-ground'));
    request();
  }

  return {
    scene, renderer, views: Object.keys(VIEWS), look, request, recolor,
    /** The present picture as a PNG. */
    still() {
      pace.best();
      draw();
      return renderer.domElement.toDataURL('image/png');
    },
    onDraw: (f) => after.push(f),
    /** Tells what the camera has to hold; the box is in the frame of the world. */
    frame(box) {
      bounds.copy(box);
      const center = box.getCenter(new Vector3());
      const radius = Math.max(0.5, box.getSize(new Vector3()).length() / 2);
      sun.target.position.copy(center);
      sun.position.copy(center).add(new Vector3(0.9, -0.6, 1.9).multiplyScalar(radius * 1.6));
      fill.position.copy(center).add(new Vector3(-1, 1, 0.3));
      Object.assign(sun.shadow.camera, { left: -radius * 1.3, right: radius * 1.3, top: radius * 1.3, bottom: -radius * 1.3, near: 0.01, far: radius * 8 });
      sun.shadow.camera.updateProjectionMatrix();
    },
    resize(width, height) {
      if (width < 2 || height < 2) return;
      size = [width, height];
      camera.aspect = width / height;
      camera.updateProjectionMatrix();
      renderer.setSize(width, height, false);
      draw();
    },
  };
}

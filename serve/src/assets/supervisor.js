// The page of whoever watches over a mission: the plan and the map as they are, what happened, what to tell.

import { byId, clock, el, listen, may, online, say, tell, time } from './common.js';

const SVG = 'http://www.w3.org/2000/svg';
let state = null;
let drawn = -1;
let drawing = false;
let moving = null;

function show(next) {
  state = next;
  document.title = `${state.mission}: supervisor`;
  byId('name').textContent = state.mission;
  byId('status').textContent = state.status;
  byId('numbers').textContent = state.numbers;
  const notes = [state.over, state.note].filter(Boolean).join(' ');
  byId('over').hidden = !notes;
  byId('over').textContent = notes;
  byId('run').textContent = state.running ? 'Stop the clock' : 'Let the clock run';
  may(byId('run'), !state.over);
  may(byId('replan'), !state.over);
  table('agents', ['who', 'does', 'page', ''], state.agents.map(agent));
  table('robots', ['who', 'does', ''], state.robots.map(robot));
  byId('events').replaceChildren(...state.events.map(
    (event) => el('li', {}, el('span', { class: 'at' }, clock(event.at)), event.text)));
  if (state.drawing !== drawn) draw();
  tick();
}

/** Redraws a table unless somebody is about to press a button in it. */
function table(id, titles, rows) {
  const told = JSON.stringify(rows.map((row) => row.key));
  const place = byId(id);
  if (place.dataset.told === told) return;
  place.dataset.told = told;
  place.replaceChildren(el('tr', {}, ...titles.map((title) => el('th', {}, title))), ...rows.map((row) => row.draw()));
}

/** A button that acts at its second press, within some seconds. */
function twice(label, body) {
  let sure = false;
  const button = el('button', { class: 'small', type: 'button' }, label);
  button.addEventListener('click', () => {
    if (sure) tell(body);
    sure = !sure;
    button.textContent = sure ? 'Sure?' : label;
    button.classList.toggle('sure', sure);
    if (sure) setTimeout(() => { sure = false; button.textContent = label; button.classList.remove('sure'); }, 4000);
  });
  return button;
}

function tools(row, what) {
  if (row.lost) return [el('button', { class: 'small', type: 'button', onclick: () => tell({ what: 'back', ...what }) }, 'Is back')];
  const tools = [twice('Lost', { what: 'lost', ...what })];
  if (row.fails) tools.unshift(twice('Failed', { what: 'failed', ...what, until: row.until }), ' ');
  if (row.until !== null) {
    const longer = () => tell({ what: 'longer', ...what, until: row.until + 30 });
    tools.unshift(el('button', { class: 'small', type: 'button', title: 'takes 30 s longer', onclick: longer }, '+30 s'), ' ');
  }
  return tools;
}

function agent(row, index) {
  return { key: row, draw: () => el('tr', {},
    el('td', {}, row.name), el('td', {}, row.doing), el('td', { class: 'quiet' }, row.page),
    el('td', { class: 'tools' },
      state.moves ? el('button', { class: 'small', type: 'button', onclick: () => choose(index, row.name) }, 'Moved') : null, ' ',
      ...tools(row, { agent: index }), ' ',
      row.paged ? el('button', { class: 'small', type: 'button', onclick: () => invite(index, row.name) }, 'New link') : null)) };
}

function robot(row, index) {
  // Where it is changes all the time, and is no matter of the table.
  return { key: { ...row, at: null }, draw: () => el('tr', {},
    el('td', {}, row.name), el('td', {}, row.doing), el('td', { class: 'tools' }, ...tools(row, { robot: index }))) };
}

async function invite(index, name) {
  const answer = await tell({ what: 'invite', agent: index });
  if (!answer) return;
  byId('invited').hidden = false;
  byId('invited').replaceChildren(`For ${name}, opens once: `, el('code', {}, location.origin + answer.link));
}

function choose(index, name) {
  moving = index;
  byId('whom').textContent = `${name} is now at`;
  byId('move').hidden = false;
  byId('x').focus();
}

byId('stay').addEventListener('click', () => { moving = null; byId('move').hidden = true; });
byId('move').addEventListener('submit', (event) => {
  event.preventDefault();
  const place = [byId('x').valueAsNumber, byId('y').valueAsNumber];
  if (moving === null || !place.every(Number.isFinite)) return say('Two numbers are needed.', true);
  tell({ what: 'moved', agent: moving, place }).then((taken) => { if (taken) { moving = null; byId('move').hidden = true; } });
});
byId('map').addEventListener('click', (event) => {
  const svg = byId('map').querySelector('svg');
  const frame = svg?.querySelector('g.robots');
  if (moving === null || !frame) return;
  const at = new DOMPoint(event.clientX, event.clientY).matrixTransform(svg.getScreenCTM().inverse());
  const { x, y, scale } = frame.dataset;
  byId('x').value = ((at.x - x) / scale).toFixed(2);
  byId('y').value = ((y - at.y) / scale).toFixed(2);
});
byId('run').addEventListener('click', () => tell({ what: state.running ? 'stop' : 'run' }));
byId('replan').addEventListener('click', () => tell({ what: 'replan' }));

const pause = (ms) => new Promise((resolve) => { setTimeout(resolve, ms); });

/** Fetches both pictures, at most every two seconds; what is no picture is not shown. */
async function draw() {
  if (drawing) return;
  drawing = true;
  while (state.drawing !== drawn && online()) {
    const version = state.drawing;
    for (const id of ['gantt', 'map']) {
      const text = await fetch(`${id}.svg`).then((answer) => (answer.ok ? answer.text() : ''), () => '');
      const root = new DOMParser().parseFromString(text, 'image/svg+xml').documentElement;
      if (root.namespaceURI !== SVG || root.querySelector('parsererror')) continue;
      byId(id).replaceChildren(document.importNode(root, true));
    }
    drawn = version;
    tick();
    await pause(2000);
  }
  drawing = false;
}

/** Moves the line of the present and the robots. */
function tick() {
  if (!state) return;
  const now = time.now();
  byId('clock').textContent = clock(now) + (time.running ? '' : ' (stands)');
  const present = byId('gantt').querySelector('g.present');
  if (present) {
    const { left, scale, start } = present.dataset;
    const width = present.ownerSVGElement.viewBox.baseVal.width;
    const x = Math.min(Number(left) + (now - start) * scale, width - 16);
    present.querySelector('.past').setAttribute('width', Math.max(0, x - left));
    const line = present.querySelector('path.now');
    line.setAttribute('d', line.getAttribute('d').replace(/^M[\d.]+/, `M${x.toFixed(1)}`));
  }
  const frame = byId('map').querySelector('g.robots');
  state.robots.forEach((robot, index) => {
    const mark = frame?.children[index];
    if (!mark || !robot.at) return;
    const { x, y, scale } = frame.dataset;
    mark.setAttribute('transform', `translate(${(Number(x) + robot.at[0] * scale).toFixed(1)} ${(y - robot.at[1] * scale).toFixed(1)})`);
  });
}

listen(show);
setInterval(tick, 250);

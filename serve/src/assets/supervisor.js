// The page of the supervisor: the plan, the map, events, and requests. Buttons come from the server, each with the request that
// it sends.

import { byId, clock, el, listen, may, online, tell, time } from './common.js';
import { fetchPicture, moveMarks, placePicker, pointForm } from './map.js';

byId('places').append(pointForm());
const choose = placePicker();
let state = null;
let drawn = -1;
let drawing = false;

function show(next) {
  state = next;
  document.title = `${state.mission}: supervisor`;
  byId('name').textContent = state.mission;
  byId('status').textContent = state.status;
  byId('numbers').textContent = state.numbers;
  const notes = [state.over, state.note].filter(Boolean).join(' ');
  byId('over').hidden = !notes;
  byId('over').textContent = notes;
  byId('run').textContent = state.running ? 'Stop the clock' : 'Start the clock';
  may(byId('run'), !state.over);
  redraw('actions', state.buttons, () => state.buttons.map((b) => button(b)));
  table('people', ['who', 'does', 'page', ''], state.members.filter((row) => row.role !== 'robot'));
  table('robots', ['who', 'does', ''], state.members.filter((row) => row.role === 'robot'));
  byId('events').replaceChildren(...state.events.map(
    (event) => el('li', {}, el('span', { class: 'at' }, clock(event.at)), event.text)));
  if (state.drawing !== drawn) draw();
  tick();
}

/** Redraws an element only if its data have changed: somebody may be about to press a button in it. */
function redraw(id, data, children) {
  const key = JSON.stringify(data);
  const place = byId(id);
  if (place.dataset.key === key) return;
  place.dataset.key = key;
  place.replaceChildren(...children());
}

function table(id, titles, rows) {
  // Positions change all the time, and are not in the table.
  redraw(id, rows.map((row) => ({ ...row, at: null })), () => [
    el('tr', {}, ...titles.map((title) => el('th', {}, title))), ...rows.map((row) => drawRow(row, titles.includes('page')))]);
}

function drawRow(row, paged) {
  const tools = row.buttons.flatMap((b) => [button(b, 'small'), ' ']);
  if (row.paged) tools.push(el('button', { class: 'small', type: 'button', onclick: () => invite(row) }, 'New link'));
  return el('tr', {}, el('td', {}, row.name), el('td', {}, row.doing),
    paged ? el('td', { class: 'quiet' }, row.page) : null, el('td', { class: 'tools' }, ...tools));
}

/** A button of the server's data: it acts at once, at its second press within some seconds, or after a point is given. */
function button(data, size = '') {
  const node = el('button', { class: [size, data.main && 'main'].filter(Boolean).join(' '), type: 'button', title: data.title }, data.text);
  may(node, data.enabled);
  let sure = false;
  const reset = () => { sure = false; node.textContent = data.text; node.classList.remove('sure'); };
  node.addEventListener('click', () => {
    if (data.point) return choose(() => data);
    if (!data.confirm) return tell(data.request);
    if (sure) {
      reset();
      return tell(data.request);
    }
    sure = true;
    node.textContent = 'Sure?';
    node.classList.add('sure');
    return setTimeout(reset, 4000);
  });
  return node;
}

async function invite(row) {
  const answer = await tell({ what: 'invite', member: row.member });
  if (!answer) return;
  byId('invited').hidden = false;
  byId('invited').replaceChildren(`For ${row.name}, opens once: `, el('code', {}, location.origin + answer.link));
}

byId('run').addEventListener('click', () => tell({ what: state.running ? 'stop' : 'run' }));

const pause = (ms) => new Promise((resolve) => { setTimeout(resolve, ms); });

/** Fetches both pictures, at most every two seconds; only SVG is shown. */
async function draw() {
  if (drawing) return;
  drawing = true;
  while (state.drawing !== drawn && online()) {
    const version = state.drawing;
    for (const id of ['gantt', 'map']) await fetchPicture(id);
    drawn = version;
    tick();
    await pause(2000);
  }
  drawing = false;
}

/** Moves the line of the present, and the marks of members. */
function tick() {
  if (!state) return;
  const now = time.now();
  byId('clock').textContent = clock(now) + (time.running ? '' : ' (stopped)');
  const present = byId('gantt').querySelector('g.present');
  if (present) {
    const { left, scale, start } = present.dataset;
    const width = present.ownerSVGElement.viewBox.baseVal.width;
    const x = Math.min(Number(left) + (now - start) * scale, width - 16);
    present.querySelector('.past').setAttribute('width', Math.max(0, x - left));
    const line = present.querySelector('path.now');
    line.setAttribute('d', line.getAttribute('d').replace(/^M[\d.]+/, `M${x.toFixed(1)}`));
  }
  moveMarks(state.members.filter((row) => row.at).map((row) => row.at));
}

listen(show);
setInterval(tick, 250);

// The page of one person of a mission. Buttons and questions come from the server, each with the request that it sends.

import { byId, clock, el, listen, may, online, say, tell, time } from './common.js';
import { fetchPicture, moveMarks, placePicker, pointForm } from './map.js';
import { reminders } from './reminder.js';

byId('places').append(pointForm());
const choose = placePicker();
const remind = reminders((id) => press(id));

let person = null;
let formKey = null;
let groupKey = null;
let drawn = null;
let drawing = false;

function show(state) {
  person = state.person;
  document.title = `${person.name}: ${state.mission}`;
  byId('name').textContent = person.name;
  byId('mission').textContent = state.mission;
  byId('over').hidden = !person.note;
  byId('over').textContent = person.note ?? '';
  byId('doing').textContent = person.doing;
  byId('next').textContent = person.next;
  byId('measured').textContent = person.measured.map(
    (m) => `${m.name}: ${m.seconds === null ? 'running' : clock(m.seconds)}`).join(', ');
  groups();
  form();
  byId('places').hidden = !person.map;
  draw();
  const steps = person.steps.map((step) => el('li', { class: step.state }, el('span', { class: 'at' }, clock(step.at)), step.text));
  byId('plan').replaceChildren(...(steps.length ? steps : [el('li', { class: 'quiet' }, 'Nothing is planned for you.')]));
  byId('messages').replaceChildren(...person.messages.map(
    (m) => el('li', {}, el('span', { class: 'at' }, clock(m.at)), m.text)));
  tick();
}

const buttons = () => person.groups.flatMap((group) => group.buttons);

/** Draws the buttons. The elements stay while only headings and states change, so that a press never misses. */
function groups() {
  const key = JSON.stringify(person.groups.map((group) => group.buttons.map((b) => [b.id, b.text, b.main])));
  if (key !== groupKey) {
    groupKey = key;
    byId('groups').replaceChildren(...person.groups.map((group) => el('fieldset', {}, el('legend'),
      el('div', { class: 'pair' }, ...group.buttons.map((b) => el('button',
        { id: b.id, type: 'button', class: b.main && 'main', onclick: () => press(b.id) }, b.text))))));
  }
  const legends = byId('groups').querySelectorAll('legend');
  person.groups.forEach((group, index) => { legends[index].textContent = group.heading; });
  for (const button of buttons()) {
    const shown = byId(button.id);
    may(shown, button.enabled);
    // The number of its uses stands behind its text.
    if (button.uses === undefined) delete shown.dataset.uses;
    else shown.dataset.uses = button.uses;
  }
  remind(person.reminder, buttons());
}

/** Sends the request of a button. It names what the page shows, so that a duplicated press counts once. */
function press(id) {
  const find = () => buttons().find((b) => b.id === id);
  const button = find();
  if (!button) return;
  if (button.point) return choose(find);
  may(byId(id), false);
  say('Sending…');
  tell(button.request).then((reply) => {
    if (!reply && find()) may(byId(id), find().enabled);
  });
}

/** Fetches the map whenever it has changed, at most every two seconds. */
async function draw() {
  if (drawing || !person.map) return;
  drawing = true;
  while (person.map && person.map.drawing !== drawn && online()) {
    const version = person.map.drawing;
    await fetchPicture('map');
    drawn = version;
    tick();
    await new Promise((resolve) => { setTimeout(resolve, 2000); });
  }
  drawing = false;
}

/** Shows the questions of a form once; answers stay while the page redraws. */
function form() {
  const of = person.form;
  byId('form').hidden = !of;
  if (of) {
    byId('about').textContent = of.heading;
    byId('introduction').textContent = of.text;
  }
  if ((of?.key ?? null) !== formKey) {
    formKey = of?.key ?? null;
    byId('questions').replaceChildren(...(of?.questions ?? []).map((question) => el('fieldset', {},
      el('legend', {}, question.text),
      el('div', { class: 'five' }, ...question.answers.map((answer) => el('label', {},
        el('input', { type: 'radio', name: question.key, value: answer.value, 'aria-label': answer.text }),
        el('span', { 'aria-hidden': 'true' }, answer.text)))))));
  }
  ready();
}

function answers() {
  const chosen = (key) => byId('form').querySelector(`input[name="${key}"]:checked`)?.value;
  return (person?.form?.questions ?? []).map(({ key }) => [key, chosen(key)]);
}

function ready() {
  may(byId('send'), answers().some(([, value]) => value !== undefined));
}

byId('form').addEventListener('change', ready);
byId('form').addEventListener('submit', (event) => {
  event.preventDefault();
  if (!person?.form) return;
  const values = answers().map(([key, value]) => [key, Number(value ?? 0)]);
  may(byId('send'), false);
  tell({ ...person.form.request, ...Object.fromEntries(values) }).then(ready);
});

/** Updates everything that changes with time alone. */
function tick() {
  if (!person) return;
  const now = time.now();
  byId('clock').textContent = clock(now) + (time.running ? '' : ' (stopped)');
  const since = person.since === null ? '' : `for ${clock(now - person.since)}`;
  const until = person.until === null ? '' : `planned until ${clock(person.until)}`;
  byId('since').textContent = [since, until].filter(Boolean).join(', ');
  const left = person.countdown === null ? null : person.countdown - now;
  byId('count').hidden = left === null;
  if (left !== null) byId('count').textContent = left >= 0 ? clock(left) : `${clock(-left)} late`;
  byId('detail').textContent = person.detail ?? '';
  if (person.map) moveMarks(person.map.marks);
}

listen(show);
setInterval(tick, 250);

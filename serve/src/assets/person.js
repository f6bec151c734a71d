// The page of one person of a mission.

import { byId, clock, el, listen, may, say, tell, time } from './common.js';

// The words and their order are those of thesis 5.7.1; each step is half a unit from -1 to 1.
const QUESTIONS = [
  ['wait', 'The waiting time was', ['Too short', 'Short', 'OK', 'Long', 'Too long']],
  ['approach', 'The robot came', ['Very fast', 'Fast', 'OK', 'Slow', 'Very slow']],
  ['distance', 'It waited', ['Very far', 'Far', 'OK', 'Close', 'Very close']],
];

let person = null;
let asked = null;

for (const [key, question, words] of QUESTIONS) {
  const five = el('div', { class: 'five' });
  words.forEach((word, index) => {
    const input = el('input', { type: 'radio', name: key, value: index - 2, 'aria-label': word });
    five.append(el('label', {}, input, el('span', { 'aria-hidden': 'true' }, word)));
  });
  byId('questions').append(el('fieldset', {}, el('legend', {}, question), five));
}

function lines(list, entries) {
  byId(list).replaceChildren(...entries);
}

function show(state) {
  person = state.person;
  document.title = `${person.name}: ${state.mission}`;
  byId('name').textContent = person.name;
  byId('mission').textContent = state.mission;
  byId('over').hidden = !person.note;
  byId('over').textContent = person.note ?? '';
  byId('doing').textContent = person.doing;
  byId('next').textContent = person.next;
  byId('operation').textContent = person.operation;
  // Where nobody is served, tasks may fail.
  const served = person.service !== null;
  byId('services').hidden = !served;
  byId('failed').textContent = served ? 'The service failed' : 'It failed';
  byId('service').textContent = person.service ?? '';
  for (const [button, yes] of Object.entries(person.may)) may(byId(button), yes);
  may(byId('much'), person.may.longer);
  byId('measured').textContent = person.measured.map(
    (m) => `${m.name}: ${m.seconds === null ? 'runs' : clock(m.seconds)}`).join(', ');
  feedback(person.ask);
  lines('plan', person.steps.map((step) => el('li', { class: step.state },
    el('span', { class: 'at' }, clock(step.at)), step.text)));
  if (!person.steps.length) lines('plan', [el('li', { class: 'quiet' }, 'Nothing is planned for you.')]);
  lines('messages', person.messages.map((m) => el('li', {}, el('span', { class: 'at' }, clock(m.at)), m.text)));
  tick();
}

/** Shows the question of a service once; what was chosen stays while the page redraws. */
function feedback(ask) {
  const key = ask ? `${ask.operation}` : null;
  byId('feedback').hidden = !ask;
  if (ask) byId('about').textContent = ask.text;
  if (key !== asked) {
    asked = key;
    byId('feedback').reset();
  }
  ready();
}

function chosen() {
  return QUESTIONS.map(([key]) => [key, byId('feedback').querySelector(`input[name="${key}"]:checked`)?.value]);
}

function ready() {
  may(byId('send'), chosen().some(([, value]) => value !== undefined));
}

byId('feedback').addEventListener('change', ready);
byId('feedback').addEventListener('submit', (event) => {
  event.preventDefault();
  if (!person?.ask) return;
  const said = chosen().map(([key, value]) => [key, Number(value ?? 0)]);
  may(byId('send'), false);
  tell({ what: 'feedback', operation: person.ask.operation, ...Object.fromEntries(said) }).then(ready);
});

// What is told of an end names the end that the page shows, so that a press which comes twice counts once.
const PRESSES = {
  begin: () => ({ what: 'begin' }),
  done: () => ({ what: 'done' }),
  serve: () => ({ what: 'serve' }),
  served: () => ({ what: 'served' }),
  failed: () => ({ what: 'failed', until: person.until }),
  longer: () => ({ what: 'longer', until: person.until + 30 }),
  much: () => ({ what: 'longer', until: person.until + 120 }),
};
for (const [id, press] of Object.entries(PRESSES)) {
  byId(id).addEventListener('click', () => {
    if (!person) return;
    const told = { ...press(), operation: person.at };
    may(byId(id), false);
    say('Sending…');
    tell(told).then((taken) => {
      if (!taken) may(byId(id), person.may[told.what]);
    });
  });
}

/** What changes with time alone. */
function tick() {
  if (!person) return;
  const now = time.now();
  byId('clock').textContent = clock(now) + (time.running ? '' : ' (stands)');
  const since = person.since === null ? '' : `for ${clock(now - person.since)}`;
  const until = person.until === null ? '' : `planned until ${clock(person.until)}`;
  byId('since').textContent = [since, until].filter(Boolean).join(', ');
  const left = person.comes === null ? null : person.comes - now;
  byId('count').hidden = left === null;
  if (left !== null) byId('count').textContent = left >= 0 ? clock(left) : `${clock(-left)} late`;
  byId('who').textContent = person.robot === null ? '' : person.robot;
}

listen(show);
setInterval(tick, 250);

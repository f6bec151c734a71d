// Puts the page together from the data that `hierarq run` wrote into it.

import { h } from './dom.js';
import { readData } from './data.js';
import { isAngular, settings } from './format.js';
import { createClock } from './clock.js';
import { createHeader } from './header.js';
import { createExpectations } from './expectations.js';
import { createStates } from './states.js';
import { createHeldBack, createJoints, createLevels, createStopping, createTasks } from './tables.js';
import { createPlots } from './plots.js';
import { createReplay } from './replay.js';
import { createTransport } from './transport.js';

function timeline(data) {
  const frames = data.scene?.poses.times ?? [];
  const times = [...data.time.slice(0, 1), ...data.time.slice(-1), ...frames.slice(0, 1), ...frames.slice(-1)];
  const start = times.length ? Math.min(...times) : 0;
  const end = times.length ? Math.max(...times) : 0;
  const samples = Math.max(data.time.length, frames.length);
  return { start, end, step: samples > 1 ? (end - start) / (samples - 1) : 0 };
}

// `#t=12.3` opens the report at a time.
function timeOfAddress() {
  const found = /^#t=([0-9.]+)$/.exec(location.hash);
  return found ? Number(found[1]) : NaN;
}

function start() {
  const root = document.getElementById('report');
  const data = readData(document.getElementById('hierarq-data').textContent);
  if (data.error) {
    root.append(h('p', { class: 'note' }, data.error));
    return;
  }
  document.title = `${data.title} · Hierarq`;
  const { start, end, step } = timeline(data);
  const decimals = data.period ? Math.min(4, Math.max(2, Math.ceil(-Math.log10(data.period)))) : 2;
  const clock = createClock(start, end);
  const context = { time: data.time, clock, faults: data.faults.map((f) => f.time).filter((t) => t !== null) };

  const replay = data.scene ? createReplay(data, clock) : null;
  const states = createStates(data, clock, context.faults, decimals);
  const nav = h('nav', { class: 'plot-nav', 'aria-label': 'Plots' });
  const tables = h('div', { class: 'tables' });
  const overview = h('div', { class: `overview${replay ? '' : ' no-replay'}${data.tasks.length + data.levels.length + data.expectations.length > 0 ? '' : ' only-replay'}` }, tables, replay?.node);
  let plots = null;

  const angular = [...data.plots.map((p) => p.unit), ...data.tasks.flatMap((t) => t.measures.map((m) => m.unit)), ...data.expectations.map((e) => e.unit)].some(isAngular);
  const angleChoice = (degrees, name) => h('button', {
    type: 'button', class: 'chip', 'aria-pressed': String(settings.degrees === degrees),
    onclick: () => { settings.degrees = degrees; render(); },
  }, name);

  // Everything that shows numbers with units; done again when the unit of angles changes.
  function render() {
    plots?.destroy();
    plots = createPlots(data.plots, context);
    tables.replaceChildren(...[
      createExpectations(data, clock, decimals),
      createTasks(data, clock, decimals, (task) => (plots.has(task) ? () => plots.reveal(task) : null)),
      createJoints(data, clock, decimals), createLevels(data), createHeldBack(data, clock, decimals),
      createStopping(data),
    ].filter(Boolean));
    nav.replaceChildren(
      h('div', { class: 'plot-links' }, [states, ...plots.sections].filter(Boolean).map((s) => h('button', { type: 'button', class: 'link', onclick: () => s.node.scrollIntoView({ behavior: 'smooth' }) }, s.name))),
      h('div', { class: 'plot-tools' },
        data.plots.length > 0 && h('span', { class: 'hint' }, 'Drag to zoom, double click to reset'),
        angular && h('span', { class: 'angles', role: 'group', 'aria-label': 'Unit of angles' }, angleChoice(true, 'deg'), angleChoice(false, 'rad'))));
    nav.after(states?.node ?? '', plots.node);
  }

  root.append(createHeader(data, clock, decimals), overview, nav);
  render();
  root.append(h('footer', {}, h('p', {}, [data.generatedBy && `Written by ${data.generatedBy}.`, 'This file loads nothing from the network.', 'Keys: space plays, arrows step, escape shows the whole run.'].filter(Boolean).join(' '))));
  if (end > start) {
    document.body.append(createTransport(clock, context.faults, step, decimals));
    document.body.classList.add('with-transport');
  }

  const recolor = () => { plots.redraw(); replay?.recolor(); };
  matchMedia('(prefers-color-scheme: dark)').addEventListener('change', recolor);
  addEventListener('beforeprint', () => {
    document.documentElement.dataset.theme = 'paper';
    recolor();
    plots.print(true);
    replay?.print(true);
  });
  addEventListener('afterprint', () => {
    delete document.documentElement.dataset.theme;
    plots.print(false);
    recolor();
  });
  addEventListener('hashchange', () => clock.seek(timeOfAddress()));
  clock.seek(timeOfAddress());
}

start();

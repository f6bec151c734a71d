// The bar at the foot of the window: play, time, slider, speed, zoom. And the keys.

import { h, icon } from './dom.js';
import { timeText } from './format.js';

const PLAY = 'M4.5 2.8 13 8 4.5 13.2Z';
const PAUSE = 'M4.5 3 V13 M11.5 3 V13';
const SPEEDS = [0.25, 0.5, 1, 2, 4];
const STEPS = 10000;

/** `step`: seconds that an arrow key moves. */
export function createTransport(clock, faults, step, decimals) {
  const span = clock.end - clock.start;
  const share = (t) => (span > 0 ? (t - clock.start) / span : 0);
  const button = h('button', { type: 'button', class: 'play', onclick: () => clock.toggle() });
  const readout = h('output', { class: 'readout' });
  const slider = h('input', {
    type: 'range', min: 0, max: STEPS, step: 1, value: 0, 'aria-label': 'Time',
    oninput: () => { clock.pause(); clock.seek(clock.start + (span * slider.value) / STEPS); },
  });
  const marks = faults.map((t) => h('span', { class: 'fault-mark', title: `fault at ${timeText(t, decimals)}`, style: { left: `${share(t) * 100}%` } }));
  const window_ = h('span', { class: 'zoom-window', hidden: true });
  const speed = h('select', { 'aria-label': 'Speed', title: 'Speed', onchange: () => clock.setSpeed(Number(speed.value)) },
    SPEEDS.map((s) => h('option', { value: s, selected: s === 1 }, `${s}×`)));
  const zoom = h('button', { type: 'button', class: 'chip zoom-reset', hidden: true, onclick: () => clock.setZoom(null) });
  const node = h('div', { class: 'transport', role: 'group', 'aria-label': 'Replay' },
    button, readout, h('div', { class: 'track' }, h('div', { class: 'track-marks' }, window_, marks), slider), zoom, speed);

  function showTime() {
    slider.value = Math.round(share(clock.time) * STEPS);
    slider.style.setProperty('--done', `${share(clock.time) * 100}%`);
    slider.setAttribute('aria-valuetext', timeText(clock.time, decimals));
    readout.textContent = timeText(clock.time, decimals);
  }
  function showPlay() {
    button.replaceChildren(icon(clock.playing ? PAUSE : PLAY));
    button.classList.toggle('playing', clock.playing);
    button.setAttribute('aria-label', clock.playing ? 'Pause' : 'Play');
    button.title = `${clock.playing ? 'Pause' : 'Play'} (space)`;
  }
  function showZoom() {
    zoom.hidden = window_.hidden = clock.zoom === null;
    if (clock.zoom === null) return;
    const [from, to] = clock.zoom;
    zoom.textContent = `${timeText(from, decimals).replace(' s', '')} – ${timeText(to, decimals)}  ✕`;
    zoom.title = 'Show the whole run (or double click a plot)';
    window_.style.left = `${share(from) * 100}%`;
    window_.style.width = `${(share(to) - share(from)) * 100}%`;
  }
  clock.on('time', showTime);
  clock.on('play', showPlay);
  clock.on('zoom', showZoom);
  showTime();
  showPlay();

  document.addEventListener('keydown', (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const target = event.target;
    if (target.matches?.('select, textarea, input:not([type=range])')) return;
    const onButton = target.closest?.('button, a, summary');
    const move = (event.shiftKey ? 10 : 1) * step;
    const actions = {
      ' ': onButton ? null : () => clock.toggle(),
      ArrowLeft: () => { clock.pause(); clock.seek(clock.time - move); },
      ArrowRight: () => { clock.pause(); clock.seek(clock.time + move); },
      Home: () => { clock.pause(); clock.seek(clock.start); },
      End: () => { clock.pause(); clock.seek(clock.end); },
      Escape: () => clock.setZoom(null),
    };
    const action = actions[event.key];
    if (!action) return;
    event.preventDefault();
    action();
  });
  return node;
}

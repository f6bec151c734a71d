// Shared by both pages: the stream of states, requests to the server, times. Text of the server becomes text nodes, never markup.

export const byId = (id) => document.getElementById(id);

/** An element with attributes and children; strings become text. */
export function el(name, attributes = {}, ...children) {
  const node = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) {
    if (key === 'onclick') node.addEventListener('click', value);
    else if (value === true) node.setAttribute(key, '');
    else if (value !== false && value != null) node.setAttribute(key, value);
  }
  node.append(...children.filter((child) => child != null));
  return node;
}

/** Seconds as `3:07`, `1:02:09`; before zero with a minus. */
export function clock(seconds) {
  const whole = Math.floor(Math.abs(seconds) + 1e-9);
  const two = (n) => String(n).padStart(2, '0');
  const [h, m, s] = [Math.floor(whole / 3600), Math.floor(whole / 60) % 60, whole % 60];
  return (seconds <= -1 ? '-' : '') + (h ? `${h}:${two(m)}:${two(s)}` : `${m}:${two(s)}`);
}

/** The time of the mission: that of the last state, continued by the page's own clock. */
export const time = {
  said: 0, at: 0, speed: 1, running: false,
  set(state) {
    Object.assign(this, { said: state.time, at: performance.now(), speed: state.speed, running: state.running });
  },
  now() {
    return this.said + (this.running && connected ? (performance.now() - this.at) / 1000 * this.speed : 0);
  },
};

let connected = false;
let shown = null;

let fading = 0;

/** Shows the result of a press. Confirmations disappear after a while, refusals stay until the next result. */
export function say(text, bad = false) {
  const said = byId('said');
  clearTimeout(fading);
  said.textContent = text;
  said.classList.toggle('bad', bad);
  if (!bad) fading = setTimeout(() => { said.textContent = ''; }, 20000);
}

function link(on, text) {
  connected = on;
  const badge = byId('link');
  badge.textContent = text;
  badge.className = on ? 'on' : 'off';
  document.body.classList.toggle('offline', !on);
  for (const button of document.querySelectorAll('button')) button.disabled = !on || button.dataset.may === 'no';
  for (const input of document.querySelectorAll('input')) input.disabled = !on;
}

/** Enables a button if the mission allows it; without a connection all are disabled. */
export function may(button, yes) {
  button.dataset.may = yes ? 'yes' : 'no';
  button.disabled = !connected || !yes;
}

export const online = () => connected;

/** Listens to the states of this page while it is open, and reconnects after a lost connection. */
export function listen(show) {
  let source = null;
  let heard = 0;
  const open = () => {
    source?.close();
    heard = performance.now();
    source = new EventSource('events');
    source.addEventListener('state', (event) => {
      heard = performance.now();
      let state;
      try { state = JSON.parse(event.data); } catch { return; }
      shown = state;
      time.set(state);
      link(true, 'connected');
      show(state);
      link(true, 'connected');
    });
    source.addEventListener('error', () => {
      if (source.readyState === EventSource.CLOSED) signedOut();
      link(false, 'not connected');
    });
  };
  // The browser never retries a rejected stream, and a silent stream looks like an open one.
  setInterval(() => {
    const silent = performance.now() - heard > 12000;
    if (source.readyState === EventSource.CLOSED || silent) {
      if (silent) link(false, 'not connected');
      open();
    }
  }, 3000);
  addEventListener('offline', () => link(false, 'not connected'));
  addEventListener('online', open);
  document.addEventListener('visibilitychange', () => {
    if (document.visibilityState === 'visible' && !connected) open();
  });
  link(false, 'not connected');
  open();
  return () => shown;
}

async function signedOut() {
  const answer = await fetch('state').catch(() => null);
  if (answer?.status === 401) say('This page is no longer signed in: open a new link. The supervisor can make one.', true);
}

/** Sends a request to the server, and shows the reply; null if it was rejected. */
export async function tell(body) {
  if (!connected) {
    say('Not connected: nothing was sent. Press again once the page is connected.', true);
    return null;
  }
  try {
    const answer = await fetch('tell', {
      method: 'POST',
      headers: { 'content-type': 'application/json' },
      body: JSON.stringify(body),
      signal: AbortSignal.timeout(30000),
    });
    const json = await answer.json().catch(() => ({}));
    if (answer.ok) {
      say(json.said ?? 'Noted.');
      return json;
    }
    say(json.refused ?? `The server rejected the request (${answer.status}).`, true);
  } catch {
    say('The server has not replied. Check the page, and press again if nothing has changed.', true);
  }
  return null;
}

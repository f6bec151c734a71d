// A headless Chromium driven over its debugging pipe: enough of the protocol to open a page, act on it,
// take a picture, and hear of every console message and every request.

import { spawn } from 'node:child_process';
import { mkdtemp, rm, writeFile } from 'node:fs/promises';
import { tmpdir } from 'node:os';
import { join } from 'node:path';

const FLAGS = [
  '--headless', '--no-sandbox', '--remote-debugging-pipe', '--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--hide-scrollbars',
  '--no-first-run', '--disable-background-networking', '--disable-component-update', '--disable-sync', '--force-device-scale-factor=1',
];

/** Starts the browser; `close()` ends it. */
export async function launch(extra = []) {
  const profile = await mkdtemp(join(tmpdir(), 'hierarq-chromium-'));
  const child = spawn(process.env.CHROMIUM ?? 'chromium', [...FLAGS, ...extra, `--user-data-dir=${profile}`, 'about:blank'], { stdio: ['ignore', 'ignore', 'ignore', 'pipe', 'pipe'] });
  const waiting = new Map();
  const listeners = new Set();
  let next = 0;
  let buffer = '';
  child.stdio[4].setEncoding('utf8').on('data', (chunk) => {
    buffer += chunk;
    const messages = buffer.split('\0');
    buffer = messages.pop();
    for (const text of messages) {
      const message = JSON.parse(text);
      if (message.id === undefined) { listeners.forEach((f) => f(message)); continue; }
      const { resolve, reject } = waiting.get(message.id);
      waiting.delete(message.id);
      if (message.error) reject(new Error(message.error.message));
      else resolve(message.result);
    }
  });
  const send = (method, params = {}, sessionId = undefined) => new Promise((resolve, reject) => {
    next += 1;
    waiting.set(next, { resolve, reject });
    child.stdio[3].write(`${JSON.stringify({ id: next, method, params, sessionId })}\0`);
  });

  /** Opens a file; `problems` collects console errors and exceptions, `requests` every address asked for. */
  async function open(url, { width = 1600, height = 1000, dark = false, mobile = false } = {}) {
    const { targetId } = await send('Target.createTarget', { url: 'about:blank' });
    const { sessionId } = await send('Target.attachToTarget', { targetId, flatten: true });
    const on = (method, params) => send(method, params, sessionId);
    const problems = [];
    const requests = [];
    let loaded;
    const load = new Promise((resolve) => { loaded = resolve; });
    const hear = (message) => {
      if (message.sessionId !== sessionId) return;
      const p = message.params;
      if (message.method === 'Runtime.exceptionThrown') problems.push(p.exceptionDetails.exception?.description ?? p.exceptionDetails.text);
      if (message.method === 'Runtime.consoleAPICalled' && ['error', 'warning', 'assert'].includes(p.type)) problems.push(p.args.map((a) => a.value ?? a.description).join(' '));
      if (message.method === 'Log.entryAdded' && ['error', 'warning'].includes(p.entry.level)) problems.push(p.entry.text);
      if (message.method === 'Network.requestWillBeSent') requests.push(p.request.url);
      if (message.method === 'Page.loadEventFired') loaded();
    };
    listeners.add(hear);
    for (const domain of ['Runtime', 'Log', 'Network', 'Page']) await on(`${domain}.enable`);
    await on('Emulation.setDeviceMetricsOverride', { width, height, deviceScaleFactor: 1, mobile });
    await on('Emulation.setEmulatedMedia', { features: [{ name: 'prefers-color-scheme', value: dark ? 'dark' : 'light' }] });
    await on('Page.navigate', { url });
    await load;
    const page = {
      problems, requests, on,
      sleep: (ms) => new Promise((resolve) => { setTimeout(resolve, ms); }),
      async evaluate(expression) {
        const { result, exceptionDetails } = await on('Runtime.evaluate', { expression, awaitPromise: true, returnByValue: true });
        if (exceptionDetails) throw new Error(exceptionDetails.exception?.description ?? exceptionDetails.text);
        return result.value;
      },
      /** Waits until an expression is true; false if it does not become so within five seconds. */
      async until(expression) {
        for (let i = 0; i < 50; i += 1) {
          if (await page.evaluate(expression)) return true;
          await page.sleep(100);
        }
        return false;
      },
      mouse: (type, x, y, more = {}) => on('Input.dispatchMouseEvent', { type, x, y, ...more }),
      async key(key) {
        const text = key === ' ' ? ' ' : undefined;
        await on('Input.dispatchKeyEvent', { type: 'keyDown', key, code: key === ' ' ? 'Space' : key, text });
        await on('Input.dispatchKeyEvent', { type: 'keyUp', key });
      },
      async screenshot(path, clip = undefined) {
        const { data } = await on('Page.captureScreenshot', { format: 'png', clip });
        await writeFile(path, Buffer.from(data, 'base64'));
      },
      async pdf(path) {
        const { data } = await on('Page.printToPDF', { preferCSSPageSize: true, paperWidth: 8.27, paperHeight: 11.69, printBackground: false });
        await writeFile(path, Buffer.from(data, 'base64'));
      },
      /** Evaluates an expression as the page is on A4 paper. */
      async paper(expression) {
        await on('Emulation.setDeviceMetricsOverride', { width: 688, height: 1000, deviceScaleFactor: 1, mobile: false });
        await on('Emulation.setEmulatedMedia', { media: 'print' });
        const value = await page.evaluate(expression);
        await on('Emulation.setEmulatedMedia', { media: '' });
        return value;
      },
      async close() {
        listeners.delete(hear);
        await send('Target.closeTarget', { targetId });
      },
    };
    await page.sleep(400);
    return page;
  }

  return {
    open,
    async close() {
      const ended = new Promise((resolve) => { child.once('exit', resolve); });
      await send('Browser.close').catch(() => {});
      await ended;
      await rm(profile, { recursive: true, force: true, maxRetries: 5 });
    },
  };
}

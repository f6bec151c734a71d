// Two people and a supervisor in two browsers: presses, feedback, a reload, a lost connection, a link used twice. Then a
// mission of layers: begun, failed, done. Then a search: a goal picked on the map of a phone, a pose in a wall.

import { spawn } from 'node:child_process';
import { mkdir } from 'node:fs/promises';
import { dirname, join, resolve } from 'node:path';
import { fileURLToPath } from 'node:url';
import { createInterface } from 'node:readline';

import { launch } from '../../../views/src/report/assets/check/browser.mjs';

const here = dirname(fileURLToPath(import.meta.url));
const [binary = 'target/debug/hierarq', pictures] = process.argv.slice(2);
if (pictures) await mkdir(pictures, { recursive: true });

let failed = 0;
function check(what, good, more = '') {
  console.log(`${good ? 'ok  ' : 'FAIL'} ${what}${good || !more ? '' : `: ${more}`}`);
  if (!good) failed += 1;
}

/** A server; `links` by name. */
async function serve(spec, ...more) {
  const child = spawn(resolve(binary), ['serve', join(here, spec), '--speed', '10', ...more], { stdio: ['ignore', 'pipe', 'inherit'] });
  const links = {};
  for await (const line of createInterface({ input: child.stdout })) {
    const found = /^\s+(\S+)\s+(http:\S+)/.exec(line);
    if (found) links[found[1]] = found[2];
    if (line.includes('Ctrl-C')) break;
  }
  return { links, end: () => new Promise((done) => { child.once('exit', done); child.kill('SIGINT'); }) };
}

const text = (page, id) => page.evaluate(`document.getElementById('${id}').textContent`);
const press = (page, id) => page.evaluate(`document.getElementById('${id}').click()`);
const enabled = (id) => `document.getElementById('${id}')?.disabled === false`;
async function longer(page, expression, seconds = 40) {
  for (let i = 0; i < seconds / 5; i += 1) if (await page.until(expression)) return true;
  return false;
}
const shot = async (page, name) => { if (pictures) await page.screenshot(join(pictures, `${name}.png`)); };

/** Opens a link as a person does. */
async function enter(browser, link, look) {
  const page = await browser.open(link, look);
  await page.evaluate(`document.getElementById('open').click()`);
  await page.until(`document.getElementById('link')?.className === 'on'`);
  return page;
}

const server = await serve('field.hq');
const [first, second] = [await launch(), await launch()];
const phone = { width: 390, height: 844, mobile: true };
const anna = await enter(first, server.links.anna, phone);
const ben = await enter(second, server.links.ben, { ...phone, dark: true });
const boss = await enter(first, server.links.supervisor, { width: 1200, height: 1100 });

check('the address of a page holds no secret', (await anna.evaluate('location.pathname')) === '/person/2/');
check('no script sees the cookie', (await anna.evaluate('document.cookie')) === '');
check('a page is as wide as the phone', await anna.evaluate('document.documentElement.scrollWidth <= innerWidth'));
check('the clock is stopped at first', (await text(anna, 'over')).includes('is stopped') && !(await anna.evaluate(enabled('done'))));

await press(boss, 'run');
check('the clock runs for all', await anna.until(enabled('done')) && await ben.until(enabled('done')));
check('the chart is drawn', await boss.until(`document.querySelectorAll('#gantt [data-phase]').length > 20`));
check('the map is drawn', await boss.until(`document.querySelectorAll('#map .human').length === 3`), await text(boss, 'map'));
const line = `document.querySelector('#gantt path.now').getAttribute('d')`;
const before = await boss.evaluate(line);
check('the line of the present moves', await boss.until(`${line} !== '${before}'`));
await shot(anna, 'working');

// Both press at once.
const planned = await text(anna, 'next');
await Promise.all([press(anna, 'done'), press(ben, 'done')]);
check('anna is answered', await anna.until(`document.getElementById('said').textContent.startsWith('Noted: operation 1 ended')`), await text(anna, 'said'));
check('ben is answered', await ben.until(`document.getElementById('said').textContent.startsWith('Noted: operation 1 ended')`), await text(ben, 'said'));
check('the plan changes', await anna.until(`document.getElementById('next').textContent !== ${JSON.stringify(planned)}`), planned);
check('it counts down', await anna.until(`/^\\d+:\\d\\d( late)?$/.test(document.getElementById('count').textContent)`), await text(anna, 'count'));
check('the supervisor reads of both', await boss.until(`['anna', 'ben'].every((who) => document.getElementById('events').textContent.includes(who + ' is done'))`));
await shot(ben, 'waiting_dark');

check('anna is served', await longer(anna, enabled('serve')));
await press(anna, 'serve');
check('a service is measured', await anna.until(`document.getElementById('measured').textContent.includes('Service 1: running')`));
await press(anna, 'served');
check('and its time is shown', await anna.until(`/Service 1: \\d+:\\d\\d/.test(document.getElementById('measured').textContent)`));
check('feedback is asked for', await longer(anna, `!document.getElementById('form').hidden`));
check('nothing chosen, nothing to send', !(await anna.evaluate(enabled('send'))));
await anna.evaluate(`document.querySelector('input[name="wait"][value="2"]').click(); document.querySelector('input[name="approach"][value="-1"]').click()`);
await anna.evaluate(`document.getElementById('form').scrollIntoView()`);
await anna.sleep(700);
check('answers stay while the page gets new states', await anna.evaluate(`document.querySelector('input[name="wait"][value="2"]').checked`));
await shot(anna, 'feedback');
await press(anna, 'send');
check('feedback is thanked for', await anna.until(`document.getElementById('said').textContent.startsWith('Thank you.')`), await text(anna, 'said'));
check('and asked for no more', await anna.until(`document.getElementById('form').hidden`));
check('the supervisor reads it', await boss.until(`document.getElementById('events').textContent.includes('the wait was too long, the robot came fast')`));
await shot(boss, 'supervisor');

// A reload: everything is there again.
await anna.on('Page.reload');
await anna.sleep(500);
check('a reload keeps the page', await anna.until(`document.getElementById('name')?.textContent === 'anna' && document.getElementById('messages').textContent.includes('Your feedback')`));

// A lost connection.
const offline = (page, is) => page.on('Network.emulateNetworkConditions', { offline: is, latency: 0, downloadThroughput: -1, uploadThroughput: -1 });
await offline(anna, true);
await anna.evaluate(`dispatchEvent(new Event('offline'))`);
check('a page says that it is not connected', await anna.until(`document.getElementById('link').textContent === 'not connected'`));
check('and takes no press', await anna.evaluate(`[...document.querySelectorAll('button')].every((button) => button.disabled)`));
await shot(anna, 'not_connected');
await offline(anna, false);
check('it comes back by itself', await longer(anna, `document.getElementById('link').textContent === 'connected'`));

// A robot breaks down: two presses, and the plan of the others changes.
const robots = (text) => `[...document.querySelectorAll('#robots button')].find((button) => button.textContent === '${text}')`;
await boss.evaluate(`${robots('Lost')}.click()`);
check('one press asks', await boss.evaluate(`Boolean(${robots('Sure?')})`));
await boss.evaluate(`${robots('Sure?')}.click()`);
check('the second acts', await boss.until(`document.getElementById('robots').textContent.includes('broken down')`));
check('people read of it', await ben.until(`document.getElementById('messages').textContent.includes('m1 has broken down.')`));
await boss.evaluate(`document.querySelector('#actions button').click()`);
check('a new plan is asked for', await boss.until(`document.getElementById('events').textContent.includes('planned anew')`), await text(boss, 'said'));

// Somebody moves: the place is chosen on the map.
await boss.evaluate(`document.querySelector('#people tr:nth-child(3) button').click()`);
const box = await boss.evaluate(`(() => { document.getElementById('map').scrollIntoView(); const b = document.querySelector('#map svg').getBoundingClientRect(); return [b.x + b.width / 3, b.y + b.height / 3]; })()`);
await boss.mouse('mousePressed', box[0], box[1], { button: 'left', clickCount: 1 });
await boss.mouse('mouseReleased', box[0], box[1], { button: 'left', clickCount: 1 });
check('the map gives a place', await boss.until(`document.getElementById('x').value !== '' && document.getElementById('y').value !== ''`));
await boss.evaluate(`document.querySelector('#point button[type="submit"]').click()`);
check('and is answered', await boss.until(`/Noted|Not possible now/.test(document.getElementById('said').textContent)`), await text(boss, 'said'));

// A link that was used.
const again = await second.open(server.links.anna, phone);
check('a used link explains itself', (await again.evaluate('document.body.textContent')).includes('This link has been used.'));
await shot(again, 'used');
check('the one who used it gets to the page', (await (await first.open(server.links.anna, phone)).evaluate('location.pathname')) === '/person/2/');

// What a page does may be complained of by the browser: nothing, but for the connection that we cut.
const expected = /ERR_INTERNET_DISCONNECTED|Failed to load resource/;
for (const [name, page] of Object.entries({ anna, ben, boss })) {
  const problems = page.problems.filter((problem) => !expected.test(problem));
  check(`nothing to complain of: ${name}`, problems.length === 0, problems.join(' | '));
  const elsewhere = page.requests.filter((url) => !url.startsWith(new URL(server.links.anna).origin));
  check(`nothing from elsewhere: ${name}`, elsewhere.length === 0, elsewhere.join(' '));
}

// Layers: nobody is served, and tasks may fail.
const layers = await serve('box.hq');
const she = await enter(second, layers.links.anna, phone);
const over = await enter(first, layers.links.supervisor, { width: 1200, height: 900 });
check('nobody is served in layers', await she.until(`!document.getElementById('serve') && document.getElementById('failed') !== null`));
check('the map of layers is drawn', await over.until(`document.querySelectorAll('#map .carries').length > 0`));
await press(over, 'run');
check('it is her turn', await she.until(enabled('begin')) && (await text(she, 'doing')).startsWith('Your turn: lid: open'), await text(she, 'doing'));
await press(she, 'begin');
check('a task begins', await she.until(enabled('failed')), await text(she, 'said'));
await shot(she, 'layers');
await press(she, 'longer');
check('a task takes longer', await she.until(`document.getElementById('said').textContent.startsWith('Noted: lid takes 30 s longer')`), await text(she, 'said'));
await press(she, 'failed');
check('a task fails', await she.until(`document.getElementById('said').textContent.startsWith('Noted: lid failed.')`), await text(she, 'said'));
await she.until(enabled('begin'));
await press(she, 'begin');
await she.until(enabled('done'));
await press(she, 'done');
check('a task is done', await she.until(`document.getElementById('said').textContent.startsWith('Noted: lid was done')`), await text(she, 'said'));
check('what comes then is asked for', await she.until(`document.getElementById('doing').textContent.startsWith('Your turn: two: pick block_')`), await text(she, 'doing'));
check('the chart of layers is drawn', await over.until(`document.querySelectorAll('#gantt svg').length === 1 && document.getElementById('gantt').textContent.includes('anna')`));
check('the supervisor reads of layers', await over.until(`document.getElementById('events').textContent.includes('layer opened is done')`));
check('and what the arm does', await over.until(`document.getElementById('robots').textContent.includes('one: pick block_')`), await text(over, 'robots'));
await shot(over, 'layers_supervisor');
for (const [name, page] of Object.entries({ she, over })) {
  const problems = page.problems.filter((problem) => !expected.test(problem));
  check(`nothing to complain of: ${name}`, problems.length === 0, problems.join(' | '));
}
await layers.end();

// A search: places are picked on the map of a person's page.
const search = await serve('find.hq');
const seeker = await enter(second, search.links.anna, phone);
const chief = await enter(first, search.links.supervisor, { width: 1200, height: 900 });
await press(chief, 'run');
check('a person sees the map', await seeker.until(`document.querySelectorAll('#map .wall').length === 1`));
check('a page with a map is as wide as the phone', await seeker.evaluate('document.documentElement.scrollWidth <= innerWidth'));
await seeker.until(enabled('my_goal'));
await press(seeker, 'my_goal');
const tap = async (x, y) => {
  const at = await seeker.evaluate(`(() => {
    document.getElementById('map').scrollIntoView();
    const svg = document.querySelector('#map svg');
    const { x, y, scale } = svg.querySelector('g.robots').dataset;
    const p = new DOMPoint(Number(x) + ${x} * scale, y - ${y} * scale).matrixTransform(svg.getScreenCTM());
    return [p.x, p.y];
  })()`);
  await seeker.mouse('mousePressed', at[0], at[1], { button: 'left', clickCount: 1 });
  await seeker.mouse('mouseReleased', at[0], at[1], { button: 'left', clickCount: 1 });
  await seeker.evaluate(`document.querySelector('#point button[type="submit"]').click()`);
};
await tap(7, 2);
check('a goal is told', await seeker.until(`document.getElementById('said').textContent.startsWith('Noted: you go to (7.0, 2.0) m')`), await text(seeker, 'said'));
check('the roles follow', await seeker.until(`document.getElementById('detail').textContent.includes('peer-to-peer')`));
check('the goal is drawn', await seeker.until(`document.querySelectorAll('#map .end-of').length === 1`));
await press(seeker, 'my_pose');
await tap(5, 5);
check('a pose in a wall is refused', await seeker.until(`document.getElementById('said').textContent.includes('in a wall')`), await text(seeker, 'said'));
await shot(seeker, 'search');
await press(seeker, 'cancel');
check('a reminder blocks the page', await longer(seeker, `document.getElementById('remind').open && document.getElementById('my_goal').disabled`));
await shot(seeker, 'reminder');
await press(seeker, 'remind_now');
check('its button asks for the place', await seeker.evaluate(`!document.getElementById('remind').open && !document.getElementById('point').hidden`));
await tap(8, 2);
check('a pose ends it', await seeker.until(`document.getElementById('said').textContent.startsWith('Noted: you are at (8.0, 2.0) m') && !document.getElementById('my_goal').disabled`), await text(seeker, 'said'));
for (const [name, page] of Object.entries({ seeker, chief })) {
  const problems = page.problems.filter((problem) => !expected.test(problem) && !/409/.test(problem));
  check(`nothing to complain of: ${name}`, problems.length === 0, problems.join(' | '));
}
await search.end();

await server.end();
check('the end of the server is seen', await longer(ben, `document.getElementById('link').textContent === 'not connected'`));
await first.close();
await second.close();
console.log(failed ? `${failed} failed` : 'all good');
process.exit(failed ? 1 : 0);

// The page in a headless Chromium: on a log (seek, pause), live beside lcm-logplayer (grows, a process is killed, gw-view
// starts again). Prints what it saw; exit 1 when something did not come about.
// usage: node page_test.mjs BIN LOG CONFIG OUT      screenshots into OUT
import {spawn} from 'node:child_process';
import {createRequire} from 'node:module';
import {once} from 'node:events';
const require = createRequire(`${process.env.GW_PAGE_PACKAGES}/package.json`);
const {chromium} = require('playwright-core');

const [bin, log, config, out] = process.argv.slice(2);
const URL = `udpm://239.255.76.67:${20000 + process.pid % 10000}?ttl=0&recv_buf_size=4194304`;
const children = new Set();
let failures = 0;

function start(program, ...args) {
  const child = spawn(program, args, {stdio: ['ignore', 'pipe', 'ignore']});
  children.add(child);
  child.on('exit', () => children.delete(child));
  return child;
}

// gw-view, once it listens; with its address.
async function view(...args) {
  const child = start(`${bin}/gw-view`, ...args);
  const [line] = await once(child.stdout, 'data');
  child.address = String(line).trim();
  return child;
}

async function end(child, signal = 'SIGTERM') {
  if (child.exitCode !== null) return;
  child.kill(signal);
  await once(child, 'exit');
}

async function expect(what, page, condition, argument) {
  try {
    await page.waitForFunction(condition, argument, {timeout: 25000, polling: 100});
    console.log(`ok: ${what}`);
  } catch {
    console.log(`FAILED: ${what}`);
    failures++;
  }
}

const grown = ({id, name, than}) => Number(document.getElementById(id).dataset[name] ?? 0) > than;
const value = (page, id, name) => page.evaluate(([i, n]) => Number(document.getElementById(i).dataset[n] ?? 0), [id, name]);

async function onALog(page) {
  const server = await view(log, '--listen', '127.0.0.1:0', '--speed', '0.5');
  await page.goto(server.address, {waitUntil: 'domcontentloaded'});
  await expect('way grows', page, grown, {id: 'scene', name: 'wayPoints', than: 10});
  const before = await value(page, 'scene', 'wayPoints');
  await expect('and goes on growing', page, grown, {id: 'scene', name: 'wayPoints', than: before + 10});
  await expect('landmarks come', page, grown, {id: 'scene', name: 'landmarks', than: 40});
  await expect('images come', page, grown, {id: 'image', name: 'count', than: 3});
  await expect('charts move', page, grown, {id: 'charts', name: 'points', than: 3});
  await page.$eval('#pause', (button) => button.click());
  await expect('pause', page, () => document.getElementById('pause').textContent === 'play');
  await page.$eval('#seek', (bar) => { bar.value = 14; bar.dispatchEvent(new Event('input')); bar.dispatchEvent(new Event('change')); });
  await expect('seek to the blind span', page, () => Math.abs(Number(document.getElementById('playback').dataset.position) - 14) < 0.1);
  await page.$eval('#speed', (list) => { list.value = '0.5'; list.dispatchEvent(new Event('change')); });
  await page.$eval('#pause', (button) => button.click());
  await expect('shows that it is blind', page, () => document.getElementById('tracking').dataset.status === 'dr_only');
  await expect('explains why', page, () => document.getElementById('explanation').textContent.includes('dark, blank or covered'));
  await expect('says what to do', page, () => document.querySelector('[data-process=gw-frontend] .action')?.textContent.includes('clean the lens'));
  await page.screenshot({path: `${out}/log.png`});
  await page.$eval('#speed', (list) => { list.value = '2'; list.dispatchEvent(new Event('change')); });
  await page.$eval('#seek', (bar) => { bar.value = 27; bar.dispatchEvent(new Event('change')); });
  await expect('a process that fell silent is named', page, () => document.querySelector('[data-process=gw-backend]')?.dataset.state === 'silent');
  await expect('the worst is named first', page, () => document.getElementById('worst').textContent.startsWith('gw-backend'));
  await expect('says when images have stopped', page, () => document.getElementById('tracking').dataset.status.startsWith('no_'));
  await end(server);
}

async function live(page) {
  let server = await view('--config', config, '--lcm-url', URL, '--listen', '127.0.0.1:0');
  const address = server.address.match(/127[^/]*/)[0];
  await page.goto(server.address, {waitUntil: 'domcontentloaded'});
  const backend = start(`${bin}/gw-backend`, '--config', config, '--lcm-url', URL);
  start('lcm-logplayer', `--lcm-url=${URL}`, '--regexp=^(CAMERA|FRAME_DETAIL|FRAME_POSE|POSE|DR|GROUND_TRUTH)$', log);
  await expect('live: way grows', page, grown, {id: 'scene', name: 'wayPoints', than: 10});
  await expect('live: images come', page, grown, {id: 'image', name: 'count', than: 3});
  await expect('live: process is seen', page, () => ['ok', 'starting', 'degraded'].includes(document.querySelector('[data-process=gw-backend]')?.dataset.state));
  await end(backend, 'SIGKILL');
  await expect('live: killed process is silent', page, () => document.querySelector('[data-process=gw-backend]')?.dataset.state === 'silent');
  await page.screenshot({path: `${out}/killed.png`});
  await end(server, 'SIGKILL');
  await expect('live: page says that it lost gw-view', page, () => document.getElementById('connection').dataset.state === 'lost');
  server = await view('--config', config, '--lcm-url', URL, '--listen', address);
  await expect('live: page is back by itself', page, () => document.getElementById('connection').dataset.state === 'ok');
  const before = await value(page, 'image', 'count');
  await expect('live: images go on', page, grown, {id: 'image', name: 'count', than: before + 2});
  await end(server);
}

const browser = await chromium.launch({executablePath: process.env.GW_CHROMIUM, args: ['--no-sandbox', '--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader']});
try {
  const page = await browser.newPage({viewport: {width: 1000, height: 700}});
  page.setDefaultTimeout(60000);
  page.on('pageerror', (error) => { console.log(`FAILED: script: ${error.message}`); failures++; });
  page.on('console', (message) => { if (message.type() === 'error' && !/WebSocket|ERR_CONNECTION/.test(message.text())) console.log(`console: ${message.text()}`); });
  await onALog(page);
  await live(page);
} finally {
  for (const child of children) child.kill('SIGKILL');
  await browser.close();
}
process.exit(failures > 0 ? 1 : 0);

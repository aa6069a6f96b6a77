// A report in a headless Chromium, from the disk: what is shown, values under the cursor, zoom; nothing is fetched. Exit 1 when
// something is missing.
// usage: node report_check.mjs REPORT.html OUT.png     environment GW_PAGE_SIZE=WIDTHxHEIGHT, GW_PAGE_THEME=dark|light
import {createRequire} from 'node:module';
const require = createRequire(`${process.env.GW_PAGE_PACKAGES}/package.json`);
const {chromium} = require('playwright-core');

const [report, out] = process.argv.slice(2);
const [width, height] = (process.env.GW_PAGE_SIZE ?? '1280x900').split('x').map(Number);
let failures = 0;

function claim(what, holds) {
  console.log(`${holds ? 'ok' : 'FAILED'}: report: ${what}`);
  if (!holds) failures++;
}

async function checkRun(page) {
  const value = (id, name) => page.evaluate(([i, n]) => Number(document.getElementById(i).dataset[n] ?? 0), [id, name]);
  await page.waitForFunction(() => Number(document.getElementById('charts').dataset.points ?? 0) > 0);
  claim('the way is there', await value('scene', 'wayPoints') > 10);
  claim('landmarks are there', await value('scene', 'landmarks') > 40);
  claim('images are there', await value('image', 'count') > 10);
  const over = await page.$('#charts .u-over');
  await over.scrollIntoViewIfNeeded();
  const box = await over.boundingBox();
  const legend = () => page.$eval('#charts .u-legend', (element) => element.textContent);
  await page.mouse.move(box.x + 0.2 * box.width, box.y + box.height / 2);
  await page.waitForFunction(() => document.getElementById('image-note').textContent === 'image under the cursor');
  const early = await legend();
  await page.mouse.move(box.x + 0.7 * box.width, box.y + box.height / 2);
  claim('values follow the cursor', early !== await legend());
  const ticks = () => page.evaluate(() => document.querySelector('#charts canvas').toDataURL());
  const before = await ticks();
  await page.mouse.move(box.x + 0.4 * box.width, box.y + 20);
  await page.mouse.down();
  await page.mouse.move(box.x + 0.6 * box.width, box.y + 40, {steps: 5});
  await page.mouse.up();
  await page.waitForTimeout(300);
  claim('a stretch is zoomed into', before !== await ticks());
  await page.mouse.dblclick(box.x + 0.5 * box.width, box.y + 30);
}

async function checkFigures(page) {
  claim('figures are there', await page.$$eval('.xy canvas, .bar', (all) => all.length) > 0);
  const canvas = await page.$('.xy canvas');
  if (!canvas) return;
  await canvas.scrollIntoViewIfNeeded();
  const box = await canvas.boundingBox();
  let said = '';
  for (let x = 0.1; x < 1 && !said; x += 0.02) {
    for (let y = 0.1; y < 0.9 && !said; y += 0.1) {
      await page.mouse.move(box.x + x * box.width, box.y + y * box.height);
      said = await page.$eval('.xy .value', (element) => element.textContent);
    }
  }
  claim(`a point says its values: ${said}`, said !== '');
}

const browser = await chromium.launch({executablePath: process.env.GW_CHROMIUM, args: ['--no-sandbox', '--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader']});
try {
  const page = await browser.newPage({viewport: {width, height}, colorScheme: process.env.GW_PAGE_THEME ?? 'light'});
  page.setDefaultTimeout(60000);
  page.on('pageerror', (error) => claim(`script: ${error.message}`, false));
  page.on('request', (request) => { if (!/^(file|data|blob):/.test(request.url())) claim(`fetches ${request.url()}`, false); });
  await page.goto(`file://${report}`);
  await page.waitForSelector('body[data-ready=true]');
  await page.waitForTimeout(1000);
  await page.screenshot({path: out, fullPage: true});
  if (await page.$('#run:not([hidden])')) await checkRun(page);
  await checkFigures(page);
} finally {
  await browser.close();
}
process.exit(failures > 0 ? 1 : 0);

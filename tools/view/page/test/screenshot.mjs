// Screenshots of the page, each some seconds after it was opened.
// usage: node screenshot.mjs ADDRESS SECONDS OUT.png [SECONDS OUT.png...]     environment GW_PAGE_SIZE=WIDTHxHEIGHT, GW_PAGE_THEME=dark|light
import {createRequire} from 'node:module';
const require = createRequire(`${process.env.GW_PAGE_PACKAGES}/package.json`);
const {chromium} = require('playwright-core');

const [address, ...pictures] = process.argv.slice(2);
const [width, height] = (process.env.GW_PAGE_SIZE ?? '1280x900').split('x').map(Number);
const browser = await chromium.launch({executablePath: process.env.GW_CHROMIUM, args: ['--no-sandbox', '--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader']});
const page = await browser.newPage({viewport: {width, height}, colorScheme: process.env.GW_PAGE_THEME ?? 'light'});
page.setDefaultTimeout(60000);
await page.goto(address, {waitUntil: 'domcontentloaded'});
console.log('open');
const opened = Date.now();
for (let i = 0; i + 1 < pictures.length; i += 2) {
  await page.waitForTimeout(Math.max(0, 1000 * Number(pictures[i]) - (Date.now() - opened)));
  await page.screenshot({path: pictures[i + 1]});
}
await browser.close();

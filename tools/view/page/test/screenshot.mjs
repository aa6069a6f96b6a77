// One screenshot of the page, some seconds after it was opened.
// usage: node screenshot.mjs ADDRESS SECONDS OUT.png
import {createRequire} from 'node:module';
const require = createRequire(`${process.env.GW_PAGE_PACKAGES}/package.json`);
const {chromium} = require('playwright-core');

const [address, seconds, out] = process.argv.slice(2);
const browser = await chromium.launch({executablePath: process.env.GW_CHROMIUM, args: ['--no-sandbox', '--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader']});
const page = await browser.newPage({viewport: {width: 1280, height: 900}});
page.setDefaultTimeout(60000);
await page.goto(address, {waitUntil: 'domcontentloaded'});
console.log('open');
await page.waitForTimeout(1000 * Number(seconds));
await page.screenshot({path: out});
await browser.close();

// Starts Debian's Chromium, and its Firefox on a display of its own, for tests; shows pages with the module and three.js.
import assert from 'node:assert/strict';
import { spawn } from 'node:child_process';
import { once } from 'node:events';
import { cpSync, existsSync, writeFileSync } from 'node:fs';
import path from 'node:path';
import { chromium, firefox } from 'playwright-core';
import { serve } from '../serve.mjs';
import { built, scratch } from './support.mjs';

const find = (...files) => files.find((file) => existsSync(file));

const chromiumPath = find('/usr/bin/chromium', '/usr/bin/google-chrome');
export const skip = chromiumPath ? false : 'no Chromium; on Debian: apt-get install chromium';

export const startBrowser = () =>
  chromium.launch({
    executablePath: chromiumPath,
    args: ['--no-sandbox', '--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader'],
  });

const firefoxPath = find('/usr/bin/firefox-esr', '/usr/bin/firefox');
const displayPath = find('/usr/bin/Xvfb');
export const skipFirefox =
  firefoxPath && displayPath ? false : 'no Firefox or no Xvfb; on Debian: apt-get install firefox-esr xvfb';

// Without a display Firefox has no WebGL. Playwright drives it by WebDriver BiDi, for which it needs no patches.
export async function startFirefox(preferences = {}) {
  const display = spawn(displayPath, ['-displayfd', '3', '-screen', '0', '1600x1200x24', '-nolisten', 'tcp'], {
    stdio: ['ignore', 'ignore', 'ignore', 'pipe'],
  });
  const [number] = await once(display.stdio[3], 'data');
  const browser = await firefox.launch({
    channel: 'moz-firefox',
    executablePath: firefoxPath,
    headless: false,
    env: { ...process.env, DISPLAY: `:${number.toString().trim()}`, MOZ_ENABLE_WAYLAND: '0' },
    firefoxUserPrefs: { 'webgl.force-enabled': true, ...preferences },
  });
  browser.on('disconnected', () => display.kill());
  return browser;
}

// Serves a page with the module, three.js and some files, and opens it.
export async function show(test, text, files = {}) {
  const folder = scratch(test);
  cpSync(path.join(built, 'npm'), path.join(folder, 'npm'), { recursive: true });
  const three = path.join(built, 'node_modules/three');
  for (const name of ['module', 'core', 'webgpu', 'tsl']) {
    cpSync(path.join(three, `build/three.${name}.js`), path.join(folder, `three.${name}.js`));
  }
  for (const name of ['gpgpu', 'loaders', 'objects', 'utils']) { // what the renderer of splats needs
    cpSync(path.join(three, 'examples/jsm', name), path.join(folder, 'addons', name), { recursive: true });
  }
  for (const [name, bytes] of Object.entries(files)) writeFileSync(path.join(folder, name), bytes);
  writeFileSync(path.join(folder, 'index.html'), text);
  const server = await serve(folder);
  test.after(() => server.close());
  const browser = await startBrowser();
  test.after(() => browser.close());
  const tab = await browser.newPage();
  tab.errors = [];
  tab.on('pageerror', (error) => tab.errors.push(error.message));
  await tab.goto(`http://127.0.0.1:${server.address().port}/`);
  return tab;
}

// Returns what the page puts into window.result.
export async function resultOf(tab) {
  await tab
    .waitForFunction(() => window.result, null, { timeout: 300000 })
    .catch((error) => assert.fail(`${tab.errors.join('; ')} ${error.message}`));
  return tab.evaluate(() => window.result);
}

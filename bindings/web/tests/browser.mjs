// Starts Debian's Chromium, and its Firefox on a display of its own, for tests.
import { spawn } from 'node:child_process';
import { once } from 'node:events';
import { existsSync } from 'node:fs';
import { chromium, firefox } from 'playwright-core';

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

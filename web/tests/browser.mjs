// Starts Debian's Chromium without a window, for tests.
import { existsSync } from 'node:fs';
import { chromium } from 'playwright-core';

const executablePath = ['/usr/bin/chromium', '/usr/bin/google-chrome'].find((file) => existsSync(file));
export const skip = executablePath ? false : 'no Chromium; on Debian: apt-get install chromium';

export const startBrowser = () =>
  chromium.launch({
    executablePath,
    args: ['--no-sandbox', '--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader'],
  });

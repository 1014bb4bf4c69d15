// Prints the size of Studio's page, its start-up, and the time of the steps of a drag in Chromium without a GPU:
// node bench/page.mjs [SHAPE]; without one, Studio's own sphere of 40,000 vertices.
import { readdirSync, readFileSync } from 'node:fs';
import path from 'node:path';
import { gzipSync } from 'node:zlib';
import { serve } from '../serve.mjs';
import { startBrowser } from '../tests/browser.mjs';
import { built } from '../tests/support.mjs';

const site = path.join(built, 'site');
const sizes = readdirSync(site).map((name) => gzipSync(readFileSync(path.join(site, name)), { level: 9 }).length);
console.log(`${(sizes.reduce((sum, size) => sum + size) / 1e6).toFixed(2)} MB gzipped`);

const server = await serve(site);
const browser = await startBrowser();
const tab = await browser.newPage({ viewport: { width: 1200, height: 800 } });
const began = performance.now();
await tab.goto(`http://127.0.0.1:${server.address().port}/`);
await tab.waitForFunction(() => window.kneadStudio);
console.log(`${((performance.now() - began) / 1000).toFixed(2)} s from the address to the first picture`);

const shape = process.argv[2];
if (shape !== undefined) {
  await tab.evaluate(
    ([name, text]) => {
      const data = new DataTransfer();
      data.items.add(new File([Uint8Array.from(atob(text), (c) => c.charCodeAt(0))], name));
      window.dispatchEvent(new DragEvent('drop', { dataTransfer: data }));
    },
    [path.basename(shape), readFileSync(shape).toString('base64')],
  );
  await tab.waitForFunction((name) => document.title.includes(name), path.basename(shape));
}
const frame = () =>
  tab.evaluate(async () => {
    const next = () => new Promise((resolve) => requestAnimationFrame(resolve));
    await next();
    const start = performance.now();
    await next();
    return performance.now() - start;
  });
for (let i = 0; i < 20; ++i) await frame();
await tab.mouse.move(540, 400);
await frame();
await tab.mouse.down();
const steps = [];
for (let i = 1; i <= 20; ++i) {
  await tab.mouse.move(540 + 6 * i, 400 - 3 * i);
  steps.push(await frame());
}
await tab.mouse.up();
steps.sort((a, b) => a - b);
console.log(`a picture of a drag: ${steps[10].toFixed(0)} ms (median of 20), ${steps[19].toFixed(0)} ms at most`);
const memory = await tab.evaluate(() => window.kneadStudio.HEAPU8.length);
console.log(`${(memory / 1e6).toFixed(0)} MB of WebAssembly's memory`);
await browser.close();
server.close();

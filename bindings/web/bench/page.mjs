// Prints the size of Studio's page, its start-up, and a drag in Chromium without a GPU: node bench/page.mjs [SHAPE]
// [THREADS]; without a shape, Studio's own sphere of 40,000 vertices. The drag is measured twice: as it is, and with
// WebGL's calls that draw left out, because SwiftShader draws on the CPU.
import { readdirSync, readFileSync } from 'node:fs';
import path from 'node:path';
import { gzipSync } from 'node:zlib';
import { serve } from '../serve.mjs';
import { startBrowser } from '../tests/browser.mjs';
import { built } from '../tests/support.mjs';

const [shape, threads = '0'] = process.argv.slice(2);
const pictures = 240;

// Before the page's own scripts. Counts pictures, the time of the page's main thread in them, and vertices sent.
function watch({ draws, threads }) {
  if (threads > 0) Object.defineProperty(navigator, 'hardwareConcurrency', { value: threads });
  const gl = WebGL2RenderingContext.prototype;
  if (!draws) {
    for (const name of Object.getOwnPropertyNames(gl)) {
      if (/^(draw(Arrays|Elements|RangeElements).*|clear|clearBuffer.*|blitFramebuffer)$/.test(name)) gl[name] = () => {};
    }
  }
  const seen = (window.seen = { pictures: [], main: [], sent: [] });
  const send = gl.bufferSubData;
  let bytes = 0;
  gl.bufferSubData = function (target, offset, data, from, length) {
    bytes += length ?? data.byteLength;
    return send.call(this, target, offset, data, from, length);
  };
  const request = window.requestAnimationFrame.bind(window);
  window.requestAnimationFrame = (callback) =>
    request((now) => {
      bytes = 0;
      const began = performance.now();
      callback(now);
      seen.main.push(performance.now() - began);
      seen.pictures.push(now);
      seen.sent.push(bytes);
    });
}

// Moves the pointer once a picture along a circle, as a browser would tell it.
async function dragRound(count) {
  const canvas = document.getElementById('canvas');
  const send = (type, x, y, buttons) =>
    canvas.dispatchEvent(new PointerEvent(type, { clientX: x, clientY: y, pointerId: 1, pointerType: 'mouse', button: type === 'pointermove' ? -1 : 0, buttons, bubbles: true, cancelable: true }));
  const place = (i) => [540 + 60 * Math.sin(i / 40), 400 - 60 * (1 - Math.cos(i / 40))];
  send('pointermove', ...place(0), 0);
  send('pointerdown', ...place(0), 1);
  const { seen } = window;
  const from = seen.pictures.length;
  const began = performance.now();
  let i = 0;
  while (seen.pictures.length < from + count && performance.now() < began + 60_000) {
    const last = seen.pictures.length;
    send('pointermove', ...place(++i), 1);
    while (seen.pictures.length === last) await new Promise((resolve) => setTimeout(resolve, 1));
  }
  const seconds = (performance.now() - began) / 1000;
  send('pointerup', ...place(i), 0);
  const median = (numbers) => [...numbers].sort((a, b) => a - b)[numbers.length >> 1];
  const gaps = seen.pictures.slice(from + 1).map((now, k) => now - seen.pictures[from + k]);
  return {
    rate: gaps.length / seconds,
    gap: median(gaps),
    main: median(seen.main.slice(from)),
    updates: seen.sent.slice(from).filter((bytes) => bytes > 0).length / seconds,
  };
}

async function bring(tab) {
  if (shape === undefined) return;
  await tab.setInputFiles('#files', shape);
  await tab.waitForFunction((name) => document.title.includes(name), path.basename(shape), { timeout: 120_000 });
}

async function measure(address, browser, draws) {
  const context = await browser.newContext({ viewport: { width: 1200, height: 800 } });
  await context.addInitScript(watch, { draws, threads: Number(threads) });
  const tab = await context.newPage();
  const began = performance.now();
  await tab.goto(address);
  await tab.waitForFunction(() => window.kneadStudio);
  if (draws) console.log(`${((performance.now() - began) / 1000).toFixed(2)} s from the address to the first picture`);
  await bring(tab);
  await tab.waitForTimeout(2000);
  const { rate, gap, main, updates } = await tab.evaluate(dragRound, pictures);
  const memory = await tab.evaluate(() => window.kneadStudio.HEAPU8.length);
  console.log(`${draws ? 'a drag' : 'the same without drawing'}: ${rate.toFixed(1)} pictures/s, ${gap.toFixed(1)} ms each (median), ` +
    `of it the main thread ${main.toFixed(1)} ms; the shape changes ${updates.toFixed(1)} times/s; ${(memory / 1e6).toFixed(0)} MB`);
  await context.close();
}

const site = path.join(built, 'site');
const sizes = readdirSync(site).map((name) => gzipSync(readFileSync(path.join(site, name)), { level: 9 }).length);
console.log(`${(sizes.reduce((sum, size) => sum + size) / 1e6).toFixed(2)} MB gzipped`);
const server = await serve(site);
const browser = await startBrowser();
for (const draws of [true, false]) await measure(`http://127.0.0.1:${server.address().port}/`, browser, draws);
await browser.close();
server.close();

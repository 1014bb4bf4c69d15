// Prints start, steps of a drag and memory of Studio's page beside SculptGL's, in one run, with the same shape and the
// same movements of the pointer: node bench/sculptgl.mjs FOLDER SHAPE.ply [RUNS]. The folder is SculptGL's `app`, as its
// `webpack --env release` makes it. Both pages use the tool that they begin with.
import { readFileSync } from 'node:fs';
import path from 'node:path';
import { serve } from '../serve.mjs';
import { startBrowser } from '../tests/browser.mjs';
import { built } from '../tests/support.mjs';

const [folder, shape, runs = '3'] = process.argv.slice(2);
const pages = {
  'Knead Studio': {
    root: path.join(built, 'site'),
    hasStarted: () => window.kneadStudio !== undefined,
    bring: async (tab) => {
      await tab.setInputFiles('#files', shape);
      await tab.waitForFunction((name) => document.title.includes(name), path.basename(shape));
    },
  },
  SculptGL: {
    root: folder,
    hasStarted: () => document.querySelector('.gui-topbar, .gui-sidebar') !== null,
    bring: (tab) => tab.setInputFiles('#fileopen', shape),
  },
};

// Until the picture after next: the next one may have begun before the pointer moved.
const frame = (tab) =>
  tab.evaluate(async () => {
    for (let i = 0; i < 2; ++i) await new Promise((resolve) => requestAnimationFrame(resolve));
  });

async function measure({ root, hasStarted, bring }) {
  const server = await serve(root);
  const browser = await startBrowser();
  const tab = await browser.newPage({ viewport: { width: 1200, height: 800 } });
  await tab.route((url) => url.hostname !== '127.0.0.1', (route) => route.abort()); // fonts of other servers
  const began = performance.now();
  await tab.goto(`http://127.0.0.1:${server.address().port}/`);
  await tab.waitForFunction(hasStarted);
  await frame(tab);
  const start = performance.now() - began;
  await bring(tab);
  for (let i = 0; i < 30; ++i) await frame(tab);
  await tab.mouse.move(540, 400);
  await tab.mouse.down();
  const steps = [];
  for (let i = 1; i <= 30; ++i) {
    const moved = performance.now();
    await tab.mouse.move(540 + 4 * i, 400 - 2 * i);
    await frame(tab);
    steps.push(performance.now() - moved);
  }
  await tab.mouse.up();
  if (process.env.KNEAD_WEB_PICTURES) {
    await tab.screenshot({ path: path.join(process.env.KNEAD_WEB_PICTURES, `beside_${path.basename(root)}.png`) });
  }
  const { bytes } = await tab.evaluate(() => performance.measureUserAgentSpecificMemory());
  await browser.close();
  server.close();
  steps.sort((a, b) => a - b);
  return { start, median: steps[15], most: steps[29], bytes };
}

console.log(`${path.basename(shape)}, ${(readFileSync(shape).length / 1e6).toFixed(1)} MB`);
for (let run = 0; run < Number(runs); ++run) {
  for (const [name, page] of Object.entries(pages)) {
    const { start, median, most, bytes } = await measure(page);
    console.log(`${name.padEnd(13)} start ${start.toFixed(0)} ms; a step of a drag and two pictures ${median.toFixed(0)} ms (median), ` +
      `${most.toFixed(0)} at most; memory of the page ${(bytes / 1e6).toFixed(0)} MB`);
  }
}

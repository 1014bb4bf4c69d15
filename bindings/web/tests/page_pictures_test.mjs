// The page's pictures beside those of the desktop's Studio: the same gestures at the same pixels.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { existsSync, mkdirSync, readFileSync, writeFileSync } from 'node:fs';
import path from 'node:path';
import { after, before, describe, it } from 'node:test';
import { drag, middle, openFile, settle, size, skip as noPage, startPage } from './page.mjs';
import { command, knead, scratch } from './support.mjs';

const studio = path.join(path.dirname(command ?? ''), 'knead-studio');
const skip = noPage || (existsSync(studio) ? false : "no desktop's Studio was built");

const away = { x: middle.x + 40, y: 60 }; // beside the shape
const at = (x, y) => ({ x: middle.x + x, y: middle.y + y });
const dragged = (from, to) => [{ drag: [from, to] }];
const turned = (place) => [{ click: place }, { drag: [{ x: place.x + 90, y: place.y + 70 }, { x: place.x + 40, y: place.y + 110 }] }];
// What is done with each tool after its key was pressed.
const tools = {
  ball: ['1', dragged(at(0, 0), at(150, -80))],
  capsule: ['2', dragged(at(-80, 100), at(-160, 160))],
  paint: ['3', dragged(at(-100, -60), at(90, 60))],
  points: ['4', [{ click: at(70, -60) }, ...dragged(at(70, -60), at(130, -110))]],
  curve: ['5', [...dragged(at(-60, 0), at(80, 0)), ...dragged(at(20, 0), at(30, -70))]],
  rotate: ['7', turned(at(30, 60))],
  stretch: ['8', turned(at(-30, 0))],
  twist: ['9', turned(at(-20, 40))],
  bend: ['0', turned(at(-20, 0))],
  pins: ['p', dragged(at(20, 60), at(-40, 120))],
  mask: ['m', dragged(at(-60, -40), at(80, 40))],
};

const bar = 23; // pixels, of the menus above and the status below, which a script does not have
const region = { x: 0, y: bar, width: size.width, height: size.height - 2 * bar };
const messages = { x: 0, y: 690, width: 400, height: 80 }; // are shown on the page alone
const parallel = 'Alt+5'; // the projection: the perspective of a higher picture would be another one

function scriptOf(shape, key, steps, file) {
  const pair = ({ x, y }) => [x - region.x, y - region.y];
  const lines = steps.map((step) => (step.drag ? { drag: step.drag.map(pair), steps: 8 } : { click: pair(step.click) }));
  const all = [{ size: [region.width, region.height] }, { key: parallel }, { open: shape }, { key }, ...lines, { move: pair(away) }, { picture: file }, { close: true }];
  return all.map((line) => JSON.stringify(line)).join('\n');
}

// Preferences of a person would change the pictures.
function drawOnDesktop(home, name, shape, key, steps) {
  const file = path.join(home, `${name}.png`);
  const script = path.join(home, `${name}.script`);
  writeFileSync(script, scriptOf(shape, key, steps, file));
  const env = { ...process.env, HOME: home, XDG_CONFIG_HOME: home, XDG_STATE_HOME: home };
  execFileSync(studio, ['--script', script], { env, stdio: ['ignore', 'pipe', 'pipe'] });
  return readFileSync(file);
}

async function drawOnPage(tab, key, steps) {
  await tab.keyboard.press(key);
  await settle(tab);
  for (const step of steps) {
    if (step.drag) await drag(tab, ...step.drag);
    else await tab.mouse.click(step.click.x, step.click.y);
    await settle(tab);
  }
  await tab.mouse.move(away.x, away.y);
  await tab.waitForTimeout(1500); // until all edges are smooth
  return tab.screenshot();
}

// Of pictures of the region or of the page: the mean difference of the colours from 0 to 255, and the share of pixels
// where it is over 16.
const difference = (tab, pictures) =>
  tab.evaluate(
    async ([texts, { x, y, width, height }, hidden]) => {
      const [a, b] = await Promise.all(
        texts.map(async (text) => {
          const bytes = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
          const context = new OffscreenCanvas(width, height).getContext('2d', { willReadFrequently: true });
          const picture = await createImageBitmap(new Blob([bytes]));
          if (picture.height === height) context.drawImage(picture, 0, 0);
          else context.drawImage(picture, -x, -y);
          context.clearRect(hidden.x - x, hidden.y - y, hidden.width, hidden.height);
          return context.getImageData(0, 0, width, height).data;
        }),
      );
      let sum = 0;
      let far = 0;
      for (let i = 0; i < a.length; i += 4) {
        const of = [0, 1, 2].map((k) => Math.abs(a[i + k] - b[i + k]));
        sum += of[0] + of[1] + of[2];
        if (Math.max(...of) > 16) far += 1;
      }
      return { mean: sum / (3 * width * height), far: far / (width * height) };
    },
    [pictures.map((picture) => picture.toString('base64')), region, messages],
  );

function keep(name, pictures) {
  const folder = process.env.KNEAD_WEB_PICTURES;
  if (!folder) return;
  mkdirSync(folder, { recursive: true });
  Object.entries(pictures).forEach(([where, bytes]) => writeFileSync(path.join(folder, `beside_${name}_${where}.png`), bytes));
}

describe("pictures beside the desktop's", { skip }, () => {
  let open;
  let close;
  before(async () => {
    ({ open, close } = await startPage());
  });
  after(() => close?.());

  for (const [name, [key, steps]] of Object.entries(tools)) {
    it(name, async (test) => {
      const home = scratch(test);
      const shape = path.join(home, 'sphere.ply');
      knead('make', 'sphere', '-n', '10000', '-o', shape);
      const tab = await open(test);
      for (const pressed of ['Tab', parallel]) await tab.keyboard.press(pressed); // Tab hides the panels
      await settle(tab);
      await openFile(tab, 'sphere.ply', readFileSync(shape));
      const untouched = await tab.screenshot();
      const page = await drawOnPage(tab, key, steps);
      const desktop = drawOnDesktop(home, name, shape, key, steps);
      keep(name, { page, desktop });
      const { mean, far } = await difference(tab, [page, desktop]);
      const changed = await difference(tab, [page, untouched]);
      test.diagnostic(`mean difference ${mean.toFixed(3)} of 255, ${(100 * far).toFixed(3)}% of the pixels over 16; ` +
        `by the gesture: ${changed.mean.toFixed(2)}, ${(100 * changed.far).toFixed(2)}%`);
      // What differs: edges, and the words at the pointer, which a script does not have.
      assert.ok(mean < 1.5 && far < 0.01, `mean ${mean}, far ${far}`);
      assert.ok(changed.far > 0.005 && changed.far > 4 * far, `the gesture changes ${changed.far}, and ${far} differs`);
      assert.deepEqual(tab.problems, []);
    });
  }
});

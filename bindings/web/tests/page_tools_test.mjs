// The tools of Studio's page that need more than a drag, the pressure of a pen, and bad files.
import assert from 'node:assert/strict';
import { existsSync, mkdirSync, readdirSync, readFileSync, writeFileSync } from 'node:fs';
import path from 'node:path';
import { after, before, describe, it } from 'node:test';
import { drag, drop, middle, openFile, picture, save, settle, size, skip, startPage, strokes, write } from './page.mjs';
import { complaint, knead, meshes, read, scratch } from './support.mjs';

const folder = '/home/web_user/files';

describe("the page's tools", { skip }, () => {
  let browser;
  let open;
  let close;
  before(async () => {
    ({ browser, open, close } = await startPage());
  });
  after(() => close?.());

  // A tab with a shape, which a folder of the machine has too.
  async function openShape(test, context, kind, ...options) {
    const home = scratch(test);
    const shape = path.join(home, `${kind}.ply`);
    knead('make', kind, ...options, '-o', shape);
    const tab = await open(test, context);
    await openFile(tab, `${kind}.ply`, readFileSync(shape));
    return { tab, home, shape };
  }

  const openSphere = (test, context) => openShape(test, context, 'sphere', '-n', '3000');

  async function choose(tab, key) {
    await tab.keyboard.press(key);
    await settle(tab);
  }

  // The strokes that were saved; the exported shape has the bytes that the command makes of them.
  async function strokesAsCommand({ tab, home, shape }, name) {
    await picture(tab, `tool_${name}`);
    const text = await save(tab, name);
    const exported = await write(tab, 'Control+e', 'exported.ply', 'exported.ply');
    writeFileSync(path.join(home, 'one.knead'), text);
    knead('deform', shape, path.join(home, 'one.knead'), '--keep-mesh', '-o', path.join(home, 'out.ply'));
    assert.ok(exported.equals(readFileSync(path.join(home, 'out.ply'))), 'other bytes than the command writes');
    assert.ok(!exported.equals(readFileSync(shape)), 'nothing moved');
    assert.deepEqual(tab.problems, []);
    return strokes(text).map((line) => JSON.parse(line));
  }

  const beside = { x: middle.x + 110, y: middle.y };

  it('a first model: a hand beckons', async (test) => {
    const page = await openShape(test, undefined, 'hand');
    await page.tab.waitForTimeout(1000); // until the view has come to rest
    await drag(page.tab, { x: 543, y: 165 }, { x: 600, y: 225 });
    await drag(page.tab, { x: 330, y: 225 }, { x: 275, y: 265 });
    await drag(page.tab, { x: 600, y: 355 }, { x: 655, y: 300 });
    await choose(page.tab, '9'); // twist
    await page.tab.mouse.click(460, 600);
    await settle(page.tab);
    await drag(page.tab, { x: 550, y: 670 }, { x: 500, y: 710 });
    const made = await strokesAsCommand(page, 'first_model');
    assert.deepEqual(made.map(({ tool }) => tool), ['implicit', 'implicit', 'implicit', 'twist']);
  });

  it('curve: a line is drawn and dragged', async (test) => {
    const page = await openSphere(test);
    await choose(page.tab, '5');
    await drag(page.tab, middle, beside);
    await drag(page.tab, { x: middle.x + 50, y: middle.y }, { x: middle.x + 60, y: middle.y - 70 });
    const made = await strokesAsCommand(page, 'curve');
    assert.ok(made.at(-1).tool === 'points' && made.at(-1).curves.length === 1);
  });

  it('stamp: a mesh from a file is pressed in', async (test) => {
    const page = await openSphere(test);
    const stamp = path.join(page.home, 'round.ply');
    knead('make', 'torus', '-n', '500', '-o', stamp);
    await page.tab.evaluate(
      ([file, bytes]) => window.kneadStudio.FS.writeFile(file, new Uint8Array(bytes)),
      [`${folder}/round.ply`, Array.from(readFileSync(stamp))],
    );
    await choose(page.tab, 'Control+Shift+T');
    await page.tab.keyboard.press('Control+a');
    await page.tab.keyboard.type('round.ply');
    await settle(page.tab);
    await choose(page.tab, 'Enter');
    await settle(page.tab, 20);
    await page.tab.mouse.click(middle.x, middle.y);
    await settle(page.tab, 20);
    await picture(page.tab, 'stamp_placed');
    await drag(page.tab, middle, { x: middle.x, y: middle.y + 90 }); // down is in
    const brought = page.tab.waitForEvent('download', { predicate: (file) => file.suggestedFilename() === 'round.ply' });
    mkdirSync(path.join(page.home, 'stamp_stamps'));
    brought.then((file) => file.saveAs(path.join(page.home, 'stamp_stamps/round.ply')));
    const made = await strokesAsCommand(page, 'stamp');
    assert.equal(made.at(-1).tool, 'stamp');
  });

  // The browser's letters, which need not be those of the command.
  it('print: a text is raised', async (test) => {
    const page = await openSphere(test);
    await choose(page.tab, 'u');
    await drag(page.tab, middle, { x: middle.x + 10, y: middle.y });
    await settle(page.tab, 40);
    await picture(page.tab, 'tool_print');
    const [made] = strokes(await save(page.tab, 'print')).map((line) => JSON.parse(line));
    assert.deepEqual([made.tool, made.text, made.depth < 0], ['print', 'Text', true]);
    const exported = await write(page.tab, 'Control+e', 'exported.ply', 'exported.ply');
    assert.ok(!exported.equals(readFileSync(page.shape)), 'nothing moved');
    assert.deepEqual(page.tab.problems, []);
  });

  it('mask: what is painted stays', async (test) => {
    const page = await openSphere(test);
    await choose(page.tab, 'm');
    await drag(page.tab, middle, { x: middle.x + 60, y: middle.y - 40 });
    await choose(page.tab, '1');
    await drag(page.tab, { x: middle.x - 20, y: middle.y + 20 }, { x: middle.x - 120, y: middle.y - 60 });
    const made = await strokesAsCommand(page, 'mask');
    assert.ok(made[0].mask.vertices.length > 0);
    assert.equal(made.at(-1).tool, 'implicit');
  });

  // As of a program with instructions that the browser does not know.
  it('browsers without fused multiply-adds: the same bytes', async (test) => {
    const context = await browser.newContext({ viewport: size, acceptDownloads: true });
    await context.addInitScript(() => {
      WebAssembly.validate = () => false;
    });
    const page = await openSphere(test, context);
    assert.equal(await page.tab.evaluate(() => import('./fused.js').then((fused) => fused.hasFused())), false);
    await drag(page.tab, middle, beside);
    await strokesAsCommand(page, 'composed');
  });

  // The length of a dab's path says how deep it goes.
  it('pen: paint goes deeper where it presses harder', async (test) => {
    const depths = {};
    for (const force of [0.2, 1]) {
      const context = await browser.newContext({ viewport: size, acceptDownloads: true });
      const { tab } = await openSphere(test, context);
      const pen = await context.newCDPSession(tab);
      const send = (type, x, more = {}) =>
        pen.send('Input.dispatchMouseEvent', { type, x, y: middle.y, pointerType: 'pen', force, ...more });
      await choose(tab, '3');
      await send('mouseMoved', middle.x);
      await send('mousePressed', middle.x, { button: 'left', buttons: 1, clickCount: 1 });
      for (let i = 1; i <= 8; ++i) {
        await send('mouseMoved', middle.x + 15 * i, { button: 'left', buttons: 1 });
        await settle(tab, 2);
      }
      await send('mouseReleased', middle.x + 120, { button: 'left', clickCount: 1, force: 0 });
      await settle(tab);
      const exported = await write(tab, 'Control+e', 'painted.obj', 'painted.obj');
      const heights = exported.toString().split('\n').filter((line) => line.startsWith('v '))
        .map((line) => Math.hypot(...line.split(' ').slice(1).map(Number)));
      depths[force] = Math.max(...heights);
      assert.deepEqual(tab.problems, []);
    }
    assert.ok(depths[0.2] > 1.0001 && depths[1] - 1 > 1.5 * (depths[0.2] - 1), JSON.stringify(depths));
  });

  it('goes on drawing while a long session is computed', async (test) => {
    const { tab } = await openSphere(test);
    const knob = { tool: 'bend', center: [0, 0, 0], axis: [0, 0, 1], normal: [0, 1, 0], width: 2.5 };
    const lines = Array.from({ length: 1500 }, (_, i) => JSON.stringify({ ...knob, angle_deg: i % 2 ? 60 : -60 }));
    await tab.evaluate(() => {
      const gaps = (window.gaps = []);
      let last = performance.now();
      const next = (now) => {
        gaps.push(now - last);
        last = now;
        requestAnimationFrame(next);
      };
      requestAnimationFrame(next);
    });
    const began = performance.now();
    await drop(tab, 'long.knead', new TextEncoder().encode(`{"knead": 1}\n${lines.join('\n')}\n`));
    await tab.waitForFunction(() => document.title.includes('long'), null, { timeout: 60_000 });
    const seconds = (performance.now() - began) / 1000;
    const longest = Math.max(...(await tab.evaluate(() => window.gaps))) / 1000;
    assert.ok(seconds > 2 && longest < seconds / 3, `${seconds} s; the longest pause ${longest} s`);
    assert.deepEqual(tab.problems, []);
  });

  const bad = path.join(meshes ?? '', 'bad');
  it('bad files: each gets its line, and the page lives', { skip: existsSync(bad) ? false : 'no KNEAD_TEST_MESHES' }, async (test) => {
    const home = scratch(test);
    writeFileSync(path.join(home, 'empty.knead'), '{"knead": 1}\n');
    const tab = await open(test);
    const message = () => tab.textContent('#message');
    for (const name of readdirSync(bad).filter((file) => !file.endsWith('.md'))) {
      const words = ['deform', path.join(bad, name), path.join(home, 'empty.knead'), '-o', path.join(home, `out${path.extname(name)}`)];
      const isBad = complaint(...words, '--quiet') !== null;
      const before = await message();
      await drop(tab, name, read(bad, name));
      const isDone = isBad
        ? ([file, old]) => document.getElementById('message').textContent.includes(file) && document.getElementById('message').textContent !== old
        : ([file]) => document.title.includes(file);
      await tab.waitForFunction(isDone, [name, before], { timeout: 20_000 }).catch(async () =>
        assert.fail(`${name} (${isBad ? 'bad' : 'readable'}): "${await message()}", "${await tab.title()}"`));
    }
    await drop(tab, 'good.ply', readFileSync(path.join(meshes, 'sphere_642.ply')));
    await tab.waitForFunction(() => document.title.includes('good.ply'));
    await drag(tab, middle, beside);
    assert.ok(strokes(await save(tab, 'after')).length > 0);
    assert.deepEqual(tab.problems, []);
  });
});

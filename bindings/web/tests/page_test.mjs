// Studio's page in Chromium: opens files, deforms by mouse and by touch, undoes, saves, and recovers after a killed page.
import assert from 'node:assert/strict';
import { readFileSync, writeFileSync } from 'node:fs';
import path from 'node:path';
import { after, before, describe, it } from 'node:test';
import { serve } from '../serve.mjs';
import { drag, drop, middle, openFile, picture, save, settle, site, size, skip, startPage, strokes, turn, write } from './page.mjs';
import { knead, scratch } from './support.mjs';

describe('the page of Studio', { skip }, () => {
  let browser;
  let open;
  let close;
  before(async () => {
    ({ browser, open, close } = await startPage());
  });
  after(() => close?.());

  it('deforms by mouse, undoes and exports, with the bytes of the command', async (test) => {
    const home = scratch(test);
    const sphere = path.join(home, 'sphere.ply');
    knead('make', 'sphere', '-n', '10000', '-o', sphere);
    const tab = await open(test);
    await picture(tab, 'start');
    await openFile(tab, 'sphere.ply', readFileSync(sphere));
    await drag(tab, middle, { x: middle.x + 150, y: middle.y - 80 });
    await picture(tab, 'pulled');
    const one = await save(tab, 'one');
    await drag(tab, { x: middle.x, y: middle.y + 100 }, { x: middle.x - 120, y: middle.y + 180 });
    const two = await save(tab, 'two');
    const exported = await write(tab, 'Control+e', 'exported.ply', 'exported.ply');
    await tab.keyboard.press('Control+z');
    await settle(tab, 20);
    const undone = await save(tab, 'undone');
    assert.ok(strokes(one).length > 0);
    assert.ok(strokes(two).length > strokes(one).length);
    assert.deepEqual(strokes(undone), strokes(one));
    writeFileSync(path.join(home, 'two.knead'), two);
    knead('deform', sphere, path.join(home, 'two.knead'), '--keep-mesh', '-o', path.join(home, 'out.ply'));
    assert.ok(exported.equals(readFileSync(path.join(home, 'out.ply'))), 'other bytes than the command writes');
    assert.deepEqual(tab.problems, []);
  });

  it('deforms with every tool, with the bytes of the command', async (test) => {
    const home = scratch(test);
    const sphere = path.join(home, 'sphere.ply');
    knead('make', 'sphere', '-n', '4000', '-o', sphere);
    const tab = await open(test);
    await openFile(tab, 'sphere.ply', readFileSync(sphere));
    const at = { x: middle.x - 80, y: middle.y - 60 };
    const aside = { x: at.x + 60, y: at.y - 40 };
    const steps = {
      implicit: { key: '1', act: () => drag(tab, at, aside) },
      capsule: { key: '2', act: () => drag(tab, { x: at.x, y: at.y + 160 }, { x: at.x - 60, y: at.y + 190 }) },
      paint: { key: '3', act: () => drag(tab, { x: at.x + 120, y: at.y + 60 }, { x: at.x + 180, y: at.y + 120 }) },
      points: {
        key: '4',
        act: async () => {
          await tab.mouse.click(at.x + 150, at.y);
          await settle(tab);
          await drag(tab, { x: at.x + 150, y: at.y }, { x: at.x + 190, y: at.y - 30 });
        },
      },
      rotate: { key: '7', act: () => turn(tab, { x: at.x + 60, y: at.y + 150 }) },
      stretch: { key: '8', act: () => turn(tab, { x: at.x + 30, y: at.y + 60 }) },
      twist: { key: '9', act: () => turn(tab, { x: at.x + 60, y: at.y + 100 }) },
      bend: { key: '0', act: () => turn(tab, { x: at.x + 60, y: at.y + 60 }) },
      pose: { key: 'p', act: () => drag(tab, { x: at.x + 20, y: at.y + 120 }, { x: at.x - 10, y: at.y + 150 }) },
    };
    let before = [];
    let text = '';
    for (const [tool, { key, act }] of Object.entries(steps)) {
      await tab.keyboard.press(key);
      await settle(tab);
      await act();
      await picture(tab, `tool_${tool}`);
      text = await save(tab, tool);
      assert.ok(strokes(text).length > before.length, `${tool} made no stroke`);
      const made = JSON.parse(strokes(text).at(-1)).tool;
      assert.equal(made, tool === 'capsule' ? 'implicit' : tool);
      before = strokes(text);
    }
    const exported = await write(tab, 'Control+e', 'exported.ply', 'exported.ply');
    writeFileSync(path.join(home, 'all.knead'), text);
    knead('deform', sphere, path.join(home, 'all.knead'), '--keep-mesh', '-o', path.join(home, 'out.ply'));
    assert.ok(exported.equals(readFileSync(path.join(home, 'out.ply'))), 'other bytes than the command writes');
    assert.deepEqual(tab.problems, []);
  });

  it('opens each format', async (test) => {
    const home = scratch(test);
    const tab = await open(test);
    for (const format of ['ply', 'obj', 'stl', 'off', 'glb', 'xyz']) {
      const file = path.join(home, `shape.${format}`);
      knead('make', 'torus', '-n', '2000', '-o', file);
      await drop(tab, `shape.${format}`, readFileSync(file));
      await tab.waitForFunction((name) => document.title.includes(name), `shape.${format}`, { timeout: 10_000 });
      await settle(tab);
    }
    await picture(tab, 'points');
    assert.deepEqual(tab.problems, []);
  });

  it('says what is wrong with a file, and goes on', async (test) => {
    const tab = await open(test);
    await drop(tab, 'broken.ply', new TextEncoder().encode('ply\nformat ascii 1.0\n'));
    await settle(tab, 20);
    await picture(tab, 'broken');
    assert.ok(!(await tab.title()).includes('broken'));
    await drag(tab, middle, { x: middle.x + 100, y: middle.y });
    assert.equal(strokes(await save(tab, 'after')).length > 0, true);
    assert.deepEqual(tab.problems, []);
  });

  it('offers the work again after a killed page', async (test) => {
    const context = await browser.newContext({ viewport: size, acceptDownloads: true });
    const tab = await open(test, context);
    await drag(tab, middle, { x: middle.x + 150, y: middle.y - 80 });
    await tab.waitForTimeout(2500); // stored twice a second
    await tab.close({ runBeforeUnload: false });
    const again = await open(test, context);
    await picture(again, 'recovery');
    // The button Recover.
    await again.mouse.click(425, 421);
    await settle(again, 20);
    await picture(again, 'recovered');
    assert.equal(strokes(await save(again, 'recovered')).length > 0, true);
    assert.deepEqual(again.problems, []);
  });

  it('stores nothing in a second tab, and says so', async (test) => {
    const context = await browser.newContext({ viewport: size, acceptDownloads: true });
    const first = await open(test, context);
    await drag(first, middle, { x: middle.x + 100, y: middle.y });
    const second = await open(test, context);
    const said = (tab) => tab.evaluate(() => window.notices.join('\n'));
    assert.doesNotMatch(await said(first), /stores nothing/);
    assert.match(await said(second), /another tab\. This one stores nothing/);
    // It works all the same. What is recovered is the first one's.
    await drag(second, middle, { x: middle.x - 100, y: middle.y });
    const goesRight = (line) => {
      const { path } = JSON.parse(line);
      return path.at(-1)[0] > path[0][0];
    };
    const pulls = (text) => strokes(text).filter((line) => JSON.parse(line).path); // not the settings of remeshing
    const moved = pulls(await save(second, 'second'));
    assert.ok(moved.length > 0 && !moved.some(goesRight));
    await second.waitForTimeout(2500); // stored twice a second
    await second.close({ runBeforeUnload: false });
    await first.close({ runBeforeUnload: false });
    const again = await open(test, context);
    await again.mouse.click(425, 421); // the button Recover
    await settle(again, 20);
    const recovered = pulls(await save(again, 'again'));
    assert.ok(recovered.length > 0 && recovered.every(goesRight));
    assert.deepEqual([...first.problems, ...second.problems, ...again.problems], []);
  });

  it('works by touch', async (test) => {
    const context = await browser.newContext({ viewport: size, hasTouch: true, acceptDownloads: true });
    const tab = await open(test, context);
    const client = await context.newCDPSession(tab);
    const touch = (type, points) => client.send('Input.dispatchTouchEvent', { type, touchPoints: points });
    await touch('touchStart', [{ ...middle, id: 1 }]);
    for (let i = 1; i <= 8; ++i) {
      await touch('touchMove', [{ x: middle.x + 15 * i, y: middle.y - 8 * i, id: 1 }]);
      await settle(tab, 2);
    }
    await touch('touchEnd', []);
    await settle(tab);
    const finger = strokes(await save(tab, 'finger'));
    assert.ok(finger.length > 0);
    for (const late of [0, 500]) {
      await touch('touchStart', [{ x: 500, y: 400, id: 1 }]);
      await tab.waitForTimeout(late);
      await touch('touchStart', [{ x: 500, y: 400, id: 1 }, { x: 600, y: 400, id: 2 }]);
      for (let i = 1; i <= 8; ++i) {
        await touch('touchMove', [{ x: 500 - 8 * i, y: 400, id: 1 }, { x: 600 + 12 * i, y: 410, id: 2 }]);
        await settle(tab, 2);
      }
      await touch('touchEnd', []);
      await settle(tab);
      await picture(tab, `pinched_${late}`);
      assert.deepEqual(strokes(await save(tab, `pinched_${late}`)), finger, `the second finger ${late} ms later`);
    }
    const tap = async (fingers) => {
      const begin = Date.now() / 1000; // the browser's clock of the events: this machine may be slow
      const points = [500, 560, 620].slice(0, fingers).map((x, i) => ({ x, y: 400, id: i + 1 }));
      const send = (type, touchPoints, timestamp) => client.send('Input.dispatchTouchEvent', { type, touchPoints, timestamp });
      for (let i = 1; i <= fingers; ++i) await send('touchStart', points.slice(0, i), begin + 0.02 * i);
      await send('touchEnd', [], begin + 0.15);
      await settle(tab);
    };
    await tap(2);
    assert.deepEqual(strokes(await save(tab, 'undone')), [], 'two fingers undo');
    await tap(3);
    assert.deepEqual(strokes(await save(tab, 'redone')), finger, 'three fingers redo');
    assert.deepEqual(tab.problems, []);
  });

  it('opens without a network', async (test) => {
    const context = await browser.newContext({ viewport: size });
    const tab = await open(test, context);
    await tab.waitForFunction(() => caches.match('knead_studio_threads.wasm'));
    await context.setOffline(true);
    await tab.reload();
    await tab.waitForFunction(() => window.kneadStudio, null, { timeout: 20_000 });
    assert.ok(await tab.evaluate(() => performance.getEntriesByName('knead-studio-started').length > 0));
  });

  // Without the headers for threads the service worker sends them; where it cannot run, one thread does all.
  for (const serviceWorkers of ['allow', 'block']) {
    it(`runs from a server without headers for threads, service worker: ${serviceWorkers}`, async (test) => {
      const plain = await serve(site, 0, false);
      test.after(() => plain.close());
      const context = await browser.newContext({ viewport: size, acceptDownloads: true, serviceWorkers });
      const tab = await open(test, context, `http://127.0.0.1:${plain.address().port}/`);
      const hasThreads = serviceWorkers === 'allow';
      assert.equal(await tab.evaluate(() => window.crossOriginIsolated), hasThreads);
      const said = await tab.evaluate(() => window.notices.join('\n'));
      assert.equal(/one thread only/.test(said), !hasThreads);
      await drag(tab, middle, { x: middle.x + 100, y: middle.y });
      assert.ok(strokes(await save(tab, 'pulled')).length > 0);
      assert.deepEqual(tab.problems, []);
    });
  }
});

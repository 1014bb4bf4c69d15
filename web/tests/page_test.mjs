// Studio's page in Chromium: opens files, deforms by mouse and by touch, undoes, saves, and recovers after a killed page.
import assert from 'node:assert/strict';
import { existsSync, mkdirSync, readFileSync, writeFileSync } from 'node:fs';
import path from 'node:path';
import { after, before, describe, it } from 'node:test';
import { serve } from '../serve.mjs';
import { skip as noBrowser, startBrowser } from './browser.mjs';
import { built, knead, scratch } from './support.mjs';

const site = path.join(built, 'site');
const skip = noBrowser || (existsSync(path.join(site, 'index.html')) ? false : 'the page was not built');
const size = { width: 1200, height: 800 };
const middle = { x: size.width / 2 - 60, y: size.height / 2 };
const folder = '/home/web_user/files';

describe('the page of Studio', { skip }, () => {
  let server;
  let browser;
  before(async () => {
    server = await serve(site);
    browser = await startBrowser();
  });
  after(async () => {
    await browser?.close();
    server?.close();
  });

  const address = () => `http://127.0.0.1:${server.address().port}/`;

  async function open(test, context) {
    context ??= await browser.newContext({ viewport: size, acceptDownloads: true });
    test.after(() => context.close());
    const tab = await context.newPage();
    tab.problems = [];
    tab.on('pageerror', (error) => tab.problems.push(error.message));
    tab.on('console', (message) => {
      if (message.type() === 'error' || /GL_INVALID|INVALID_/.test(message.text())) tab.problems.push(message.text());
    });
    await tab.goto(address());
    await tab.waitForFunction(() => window.kneadStudio).catch(() => assert.fail(tab.problems.join('\n')));
    await settle(tab);
    return tab;
  }

  // Until so many pictures were drawn.
  const settle = (tab, pictures = 8) =>
    tab.evaluate(async (count) => {
      for (let i = 0; i < count; ++i) await new Promise((resolve) => requestAnimationFrame(resolve));
    }, pictures);

  async function picture(tab, name) {
    if (!process.env.KNEAD_WEB_PICTURES) return;
    mkdirSync(process.env.KNEAD_WEB_PICTURES, { recursive: true });
    await settle(tab, 30);
    await tab.screenshot({ path: path.join(process.env.KNEAD_WEB_PICTURES, `${name}.png`) });
  }

  async function drag(tab, from, to, button = 'left') {
    await tab.mouse.move(from.x, from.y);
    await settle(tab, 3);
    await tab.mouse.down({ button });
    for (let i = 1; i <= 8; ++i) {
      await tab.mouse.move(from.x + ((to.x - from.x) * i) / 8, from.y + ((to.y - from.y) * i) / 8);
      await settle(tab, 1);
    }
    await tab.mouse.up({ button });
    await settle(tab);
  }

  const drop = (tab, name, bytes) =>
    tab.evaluate(
      ([file, content]) => {
        const data = new DataTransfer();
        data.items.add(new File([new Uint8Array(content)], file));
        window.dispatchEvent(new DragEvent('drop', { dataTransfer: data, bubbles: true, cancelable: true }));
      },
      [name, Array.from(bytes)],
    );

  // Presses Ctrl+S, types a name, and returns the text of the session that the browser downloads.
  async function save(tab, name) {
    const download = tab.waitForEvent('download', { timeout: 20_000 });
    await tab.keyboard.press('Control+s');
    await settle(tab);
    await tab.keyboard.press('Control+a');
    await tab.keyboard.type(name);
    await settle(tab);
    await tab.keyboard.press('Enter');
    const file = await (await download).path();
    return readFileSync(file, 'utf8');
  }

  const strokes = (text) => text.trim().split('\n').slice(1);

  it('deforms by mouse, undoes, saves, and replays with the bits of the command', async (test) => {
    const tab = await open(test);
    await picture(tab, 'start');
    await drag(tab, middle, { x: middle.x + 150, y: middle.y - 80 });
    await picture(tab, 'pulled');
    await drag(tab, { x: middle.x, y: middle.y + 100 }, { x: middle.x - 120, y: middle.y + 180 });
    const two = await save(tab, 'two');
    await tab.keyboard.press('Control+z');
    await settle(tab);
    const one = await save(tab, 'one');
    assert.ok(strokes(one).length >= 1);
    assert.ok(strokes(two).length > strokes(one).length);
    assert.ok(two.startsWith(one.split('\n').slice(1, 2).join('')) || strokes(two)[0] === strokes(one)[0]);
    const home = scratch(test);
    writeFileSync(path.join(home, 'one.knead'), one);
    knead('make', 'sphere', '-n', '40000', '-o', path.join(home, 'sphere.ply'));
    knead('deform', path.join(home, 'sphere.ply'), path.join(home, 'one.knead'), '-o', path.join(home, 'out.ply'));
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
    const context = await browser.newContext({ viewport: size });
    const tab = await open(test, context);
    await drag(tab, middle, { x: middle.x + 150, y: middle.y - 80 });
    await tab.waitForTimeout(2500); // stored twice a second
    await tab.close({ runBeforeUnload: false });
    const again = await open(test, context);
    await picture(again, 'recovery');
    await again.keyboard.press('Enter');
    await settle(again, 20);
    await picture(again, 'recovered');
    assert.deepEqual(again.problems, []);
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
    await touch('touchStart', [{ x: 500, y: 400, id: 1 }]);
    await touch('touchStart', [{ x: 500, y: 400, id: 1 }, { x: 600, y: 400, id: 2 }]);
    for (let i = 1; i <= 8; ++i) {
      await touch('touchMove', [{ x: 500 - 8 * i, y: 400, id: 1 }, { x: 600 + 12 * i, y: 410, id: 2 }]);
      await settle(tab, 2);
    }
    await touch('touchEnd', []);
    await settle(tab);
    await picture(tab, 'pinched');
    assert.deepEqual(strokes(await save(tab, 'pinched')), finger);
    assert.deepEqual(tab.problems, []);
  });

  it('opens without a network', async (test) => {
    const context = await browser.newContext({ viewport: size });
    const tab = await open(test, context);
    await tab.evaluate(() => navigator.serviceWorker.ready);
    await context.setOffline(true);
    await tab.reload();
    await tab.waitForFunction(() => window.kneadStudio, null, { timeout: 20_000 });
    assert.ok(await tab.evaluate(() => performance.getEntriesByName('knead-studio-started').length > 0));
  });
});

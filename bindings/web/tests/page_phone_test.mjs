// Studio's page on a phone, in Chromium: fingers press, scroll and type; the page gives way to the keyboard of a screen.
import assert from 'node:assert/strict';
import { after, before, describe, it } from 'node:test';
import { picture, save, settle, skip, startPage, strokes } from './page.mjs';

const phone = { viewport: { width: 390, height: 844 }, hasTouch: true, isMobile: true, acceptDownloads: true };
const middle = { x: 200, y: 340 };
const view = { x: 105, y: 18 }; // the menu

// The part of the page that is seen, which a keyboard makes smaller.
function keepVisualViewport() {
  const seen = new EventTarget();
  Object.assign(seen, { width: 390, height: 844, scale: 1 });
  Object.defineProperty(window, 'visualViewport', { value: seen });
}

describe('the page on a phone', { skip }, () => {
  let browser;
  let open;
  let close;
  before(async () => {
    ({ browser, open, close } = await startPage());
  });
  after(() => close?.());

  async function openPhone(test) {
    const context = await browser.newContext(phone);
    await context.addInitScript(keepVisualViewport);
    const tab = await open(test, context);
    const client = await context.newCDPSession(tab);
    const touch = (type, points, timestamp) =>
      client.send('Input.dispatchTouchEvent', { type, touchPoints: points, timestamp });
    const tap = async (at) => {
      await touch('touchStart', [at]);
      await touch('touchEnd', []);
      await settle(tab);
    };
    const swipe = async (from, to) => {
      await touch('touchStart', [from]);
      for (let i = 1; i <= 8; ++i) {
        await touch('touchMove', [{ x: from.x + ((to.x - from.x) * i) / 8, y: from.y + ((to.y - from.y) * i) / 8 }]);
        await settle(tab, 1);
      }
      await touch('touchEnd', []);
      await settle(tab);
    };
    return { tab, tap, swipe, touch };
  }

  const scrolls = (tab, { x, y }) => tab.evaluate(([a, b]) => window.kneadStudio._studio_scroll(a, b, 0), [x, y]);
  const isTyping = (tab) => tab.evaluate(() => document.activeElement.id === 'keyboard');

  it('a finger pulls, and scrolls a menu without choosing from it', async (test) => {
    const { tab, tap, swipe } = await openPhone(test);
    await swipe(middle, { x: 200, y: 220 });
    const pulled = strokes(await save(tab, 'pulled'));
    assert.ok(pulled.length > 0);
    await tap(view);
    const row = { x: 180, y: 400 };
    assert.equal(await scrolls(tab, row), 1, 'the menu is open');
    await swipe(row, { x: 182, y: 150 });
    assert.equal(await scrolls(tab, row), 1, 'it still is');
    await picture(tab, 'phone_menu');
    await tap({ x: 375, y: 700 });
    assert.deepEqual(strokes(await save(tab, 'after')), pulled);
    assert.deepEqual(tab.problems, []);
  });

  it('a tap on a text opens the keyboard, which writes and takes away', async (test) => {
    const { tab, tap, swipe } = await openPhone(test);
    await tab.keyboard.press('u'); // print
    await settle(tab);
    assert.equal(await isTyping(tab), false);
    await tap({ x: 290, y: 762 }); // the text in the bar, behind its end
    assert.equal(await isTyping(tab), true);
    for (let i = 0; i < 3; ++i) {
      await tab.keyboard.press('Backspace');
      await settle(tab);
    }
    await tab.keyboard.insertText('zé'); // without keys, as such keyboards do
    await settle(tab);
    await picture(tab, 'phone_text');
    await tap({ x: 100, y: 640 }); // beside the shape
    assert.equal(await isTyping(tab), false);
    await swipe(middle, { x: 220, y: 355 });
    await settle(tab, 30);
    const made = JSON.parse(strokes(await save(tab, 'print')).at(-1));
    assert.equal(made.text, 'Tzé', await tab.textContent('#message'));
    assert.deepEqual(tab.problems, []);
  });

  it('a keyboard that corrects a word, arrows and Ctrl+A act on the text', async (test) => {
    const { tab, tap, swipe } = await openPhone(test);
    await tab.keyboard.press('u'); // print
    await settle(tab);
    await tap({ x: 290, y: 762 });
    await tab.keyboard.press('Control+a');
    await tab.keyboard.insertText('teh');
    await tab.evaluate(() => {
      const field = document.getElementById('keyboard');
      field.value = `${field.value.slice(0, -2)}he`;
      field.dispatchEvent(new Event('input'));
    });
    await tab.keyboard.press('ArrowLeft');
    await tab.keyboard.insertText('m');
    await settle(tab, 40);
    await tap({ x: 100, y: 640 });
    await swipe(middle, { x: 220, y: 355 });
    await settle(tab, 30);
    const made = JSON.parse(strokes(await save(tab, 'print')).at(-1));
    assert.equal(made.text, 'thme', await tab.textContent('#message'));
    assert.deepEqual(tab.problems, []);
  });

  it('the dialog to open takes a file that the browser chooses', async (test) => {
    const { tab, tap } = await openPhone(test);
    await tab.keyboard.press('Control+o');
    await settle(tab);
    const chooser = tab.waitForEvent('filechooser');
    await tap({ x: 194, y: 246 });
    const buffer = Buffer.from('v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n');
    await (await chooser).setFiles({ name: 'chosen.obj', mimeType: 'text/plain', buffer });
    await tab.waitForFunction(() => document.title.includes('chosen.obj'));
    assert.deepEqual(tab.problems, []);
  });

  it('two taps near each other are two clicks', async (test) => {
    const { tab, touch } = await openPhone(test);
    await tab.evaluate(() => {
      const studio = window.kneadStudio;
      studio._studio_button(-1, 0, 0, 0, 0, 0); // no button; emscripten replaces a function that is called first
      const press = studio._studio_button;
      window.doubles = [];
      studio._studio_button = (...all) => {
        if (all[1] === 1) window.doubles.push(all[5]);
        press(...all);
      };
    });
    const begin = Date.now() / 1000; // the browser's clock of the events: this machine may be slow
    const near = { x: middle.x + 14, y: middle.y - 8 };
    await touch('touchStart', [middle], begin);
    await touch('touchEnd', [], begin + 0.05);
    await touch('touchStart', [near], begin + 0.2);
    await touch('touchEnd', [], begin + 0.25);
    await settle(tab);
    assert.deepEqual(await tab.evaluate(() => window.doubles), [0, 1]);
  });

  it('gives way to the keyboard of the screen', async (test) => {
    const { tab } = await openPhone(test);
    const height = () => tab.evaluate(() => document.getElementById('canvas').getBoundingClientRect().height);
    assert.equal(await height(), 844);
    await tab.evaluate(() => {
      window.visualViewport.height = 500;
      window.visualViewport.dispatchEvent(new Event('resize'));
    });
    await settle(tab);
    assert.equal(await height(), 500);
    assert.equal(await tab.evaluate(() => document.getElementById('canvas').height), 500);
    await picture(tab, 'phone_keyboard');
  });
});

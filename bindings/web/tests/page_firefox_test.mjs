// Studio's page in Firefox: opens a file, deforms it by mouse, undoes, saves, and recovers after a closed page.
import assert from 'node:assert/strict';
import { readFileSync, writeFileSync } from 'node:fs';
import path from 'node:path';
import { describe, it } from 'node:test';
import { startFirefox } from './browser.mjs';
import { drag, keepDownloads, middle, openFile, picture, save, settle, size, skipFirefox, startPage, strokes, write } from './page.mjs';
import { knead, scratch } from './support.mjs';

// Opens a sphere, pulls it twice, and compares what is exported with what the command makes of the saved session.
async function pullAndExport(test, tab) {
  const home = scratch(test);
  const sphere = path.join(home, 'sphere.ply');
  knead('make', 'sphere', '-n', '10000', '-o', sphere);
  await openFile(tab, 'sphere.ply', readFileSync(sphere));
  await drag(tab, middle, { x: middle.x + 150, y: middle.y - 80 });
  await picture(tab, 'firefox');
  const one = strokes(await save(tab, 'one'));
  await drag(tab, { x: middle.x, y: middle.y + 100 }, { x: middle.x - 120, y: middle.y + 180 });
  const exported = await write(tab, 'Control+e', 'exported.ply', 'exported.ply');
  const two = await save(tab, 'two');
  assert.ok(one.length > 0 && strokes(two).length > one.length);
  writeFileSync(path.join(home, 'two.knead'), two);
  knead('deform', sphere, path.join(home, 'two.knead'), '--keep-mesh', '-o', path.join(home, 'out.ply'));
  assert.ok(exported.equals(readFileSync(path.join(home, 'out.ply'))), 'other bytes than the command writes');
  await tab.keyboard.press('Control+z');
  await settle(tab, 20);
  assert.deepEqual(strokes(await save(tab, 'undone')), one);
  assert.deepEqual(tab.problems, []);
}

async function newContext(browser) {
  const context = await browser.newContext({ viewport: size });
  await context.addInitScript(keepDownloads);
  return context;
}

const hasFused = (tab) => tab.evaluate(() => import('./fused.js').then((fused) => fused.hasFused()));

describe('the page in Firefox', { skip: skipFirefox }, () => {
  it('deforms on threads, exports the bytes of the command, undoes, and recovers', async (test) => {
    const { browser, open, close } = await startPage(startFirefox);
    test.after(close);
    const context = await newContext(browser);
    const tab = await open(test, context);
    assert.ok(await tab.evaluate(() => window.crossOriginIsolated), 'no threads');
    await pullAndExport(test, tab);
    await tab.waitForTimeout(2500); // stored twice a second
    await tab.close({ runBeforeUnload: false });
    const again = await open(test, context);
    await again.mouse.click(425, 421); // the button Recover
    await settle(again, 20);
    await picture(again, 'firefox_recovered');
    assert.ok(strokes(await save(again, 'recovered')).length > 0);
    assert.deepEqual(again.problems, []);
  });

  it('has the same bytes without relaxed SIMD', async (test) => {
    const { browser, open, close } = await startPage(() =>
      startFirefox({ 'javascript.options.wasm_relaxed_simd': false }),
    );
    test.after(close);
    const tab = await open(test, await newContext(browser));
    assert.equal(await hasFused(tab), false);
    await pullAndExport(test, tab);
  });
});

// Files that are too large for the page: a sentence, and the document before it is still there.
import assert from 'node:assert/strict';
import { truncateSync, readFileSync, writeFileSync } from 'node:fs';
import path from 'node:path';
import { after, before, describe, it } from 'node:test';
import { drag, middle, picture, save, settle, size, skip, startPage, strokes } from './page.mjs';
import { knead, scratch } from './support.mjs';

const megabyte = 2 ** 20;

// Before the page's own scripts: WebAssembly gets no more memory than that, as on a small device.
function limitMemory(most) {
  const { Memory } = WebAssembly;
  const pages = most / 65536;
  WebAssembly.Memory = function (descriptor) {
    return new Memory({ ...descriptor, maximum: Math.min(descriptor.maximum, pages) });
  };
  WebAssembly.Memory.prototype = Memory.prototype;
  const { grow } = Memory.prototype;
  Memory.prototype.grow = function (more) {
    if (this.buffer.byteLength / 65536 + more > pages) throw new RangeError('too much');
    return grow.call(this, more);
  };
}

describe('too large files', { skip }, () => {
  let browser;
  let open;
  let close;
  before(async () => {
    ({ browser, open, close } = await startPage());
  });
  after(() => close?.());

  async function openLimited(test, most) {
    const context = await browser.newContext({ viewport: size, acceptDownloads: true });
    await context.addInitScript(limitMemory, most);
    return open(test, context);
  }

  async function isAlive(tab, name) {
    await drag(tab, middle, { x: middle.x + 100, y: middle.y - 40 });
    return strokes(await save(tab, name)).length > 0;
  }

  // Whatever it is that does not fit: the file, the mesh, the search tree, the picture.
  it('at whatever moment the memory ends', async (test) => {
    const home = scratch(test);
    const large = path.join(home, 'large.ply');
    knead('make', 'sphere', '-n', '200000', '-o', large);
    const free = await open(test);
    const used = await free.evaluate(() => window.kneadStudio.HEAPU8.length);
    await free.context().close();
    const outcomes = [];
    for (const more of [0, 16, 48, 256]) {
      const tab = await openLimited(test, Math.ceil(used / megabyte + more) * megabyte);
      const title = await tab.title();
      await tab.setInputFiles('#files', large);
      const outcome = await tab.waitForFunction(() => {
        if (document.title.includes('large')) return 'opened';
        return /not enough memory/.test(document.getElementById('message').textContent) ? 'refused' : null;
      }, null, { timeout: 60_000 });
      outcomes.push(await outcome.jsonValue());
      if (outcomes.at(-1) === 'refused') {
        await picture(tab, 'too_large');
        assert.equal(await tab.title(), title);
      }
      assert.ok(await isAlive(tab, `after_${more}`), `${more} MB`);
      assert.equal(await tab.textContent('#notice'), '');
      assert.deepEqual(tab.problems, [], `${more} MB`);
      await tab.context().close();
    }
    assert.ok(outcomes.includes('refused') && outcomes.at(-1) === 'opened', outcomes.join());
    assert.deepEqual(outcomes, [...outcomes].sort().reverse(), 'a larger memory opens less');
  });

  it('a file of 3 GB', async (test) => {
    const home = scratch(test);
    const huge = path.join(home, 'huge.ply');
    writeFileSync(huge, 'ply\n');
    truncateSync(huge, 3 * 2 ** 30);
    const tab = await open(test);
    await tab.setInputFiles('#files', huge);
    await tab.waitForFunction(() => /huge\.ply: .*use a smaller file/.test(document.getElementById('notice').textContent));
    assert.ok(await isAlive(tab, 'after'));
    assert.deepEqual(tab.problems, []);
  });
});

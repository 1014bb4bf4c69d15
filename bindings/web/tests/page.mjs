// Studio's page in a browser, as tests drive it.
import assert from 'node:assert/strict';
import { existsSync, mkdirSync, readFileSync } from 'node:fs';
import path from 'node:path';
import { serve } from '../serve.mjs';
import { skip as noChromium, skipFirefox as noFirefox, startBrowser } from './browser.mjs';
import { built } from './support.mjs';

export const site = path.join(built, 'site');
const noPage = existsSync(path.join(site, 'index.html')) ? false : 'the page was not built';
export const skip = noChromium || noPage;
export const skipFirefox = noFirefox || noPage;
export const size = { width: 1200, height: 800 };
export const middle = { x: size.width / 2 - 60, y: size.height / 2 };

// A browser and a server for the tests of a file; `close` ends both.
export async function startPage(start = startBrowser) {
  const server = await serve(site);
  const browser = await start();
  const address = `http://127.0.0.1:${server.address().port}/`;

  async function open(test, context, url = address) {
    context ??= await browser.newContext({ viewport: size, acceptDownloads: true });
    test.after(() => context.close());
    const tab = await context.newPage();
    tab.problems = [];
    tab.on('pageerror', (error) => tab.problems.push(error.message));
    tab.on('console', (message) => {
      if (message.type() === 'error' || /GL_INVALID|INVALID_/.test(message.text())) tab.problems.push(message.text());
    });
    await tab.addInitScript(keepNotices);
    await tab.goto(url);
    await tab.waitForFunction(() => window.kneadStudio).catch(() => assert.fail(tab.problems.join('\n')));
    await settle(tab);
    return tab;
  }

  async function close() {
    await browser.close();
    server.close();
  }
  return { browser, open, close };
}

// Before the page's own scripts: what the page says, which it takes away again after seconds.
function keepNotices() {
  window.notices = [];
  document.addEventListener('DOMContentLoaded', () => {
    const notice = document.getElementById('notice');
    new MutationObserver(() => window.notices.push(notice.textContent)).observe(notice, { childList: true });
  });
}

// Until so many pictures were drawn.
export const settle = (tab, pictures = 8) =>
  tab.evaluate(async (count) => {
    for (let i = 0; i < count; ++i) await new Promise((resolve) => requestAnimationFrame(resolve));
  }, pictures);

export async function picture(tab, name) {
  if (!process.env.KNEAD_WEB_PICTURES) return;
  mkdirSync(process.env.KNEAD_WEB_PICTURES, { recursive: true });
  await settle(tab, 30);
  const known = tab.problems.length;
  await tab.screenshot({ path: path.join(process.env.KNEAD_WEB_PICTURES, `${name}.png`) });
  tab.problems.length = known; // Firefox complains of a style that the driver adds
}

export async function drag(tab, from, to, button = 'left') {
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

// Places a tool that turns by a gizmo, and drags beside the gizmo, round its middle.
export async function turn(tab, at) {
  await tab.mouse.click(at.x, at.y);
  await settle(tab);
  await drag(tab, { x: at.x + 90, y: at.y + 70 }, { x: at.x + 40, y: at.y + 110 });
}

export const drop = (tab, name, bytes) =>
  tab.evaluate(
    ([file, content]) => {
      const data = new DataTransfer();
      data.items.add(new File([new Uint8Array(content)], file));
      window.dispatchEvent(new DragEvent('drop', { dataTransfer: data, bubbles: true, cancelable: true }));
    },
    [name, Array.from(bytes)],
  );

// Drops a file, and waits until it is open: the page begins with a sphere of its own, named "new sphere".
export async function openFile(tab, name, bytes) {
  await drop(tab, name, bytes);
  await tab.waitForFunction((title) => document.title.includes(title), name);
  await settle(tab);
}

// Before the page's own scripts, where the browser does not tell its driver of downloads: keeps what is downloaded.
export function keepDownloads() {
  const blobs = new Map();
  window.downloads = [];
  const { createObjectURL } = URL;
  URL.createObjectURL = (blob) => {
    const url = createObjectURL(blob);
    blobs.set(url, blob);
    return url;
  };
  const { click } = HTMLAnchorElement.prototype;
  HTMLAnchorElement.prototype.click = function () {
    if (blobs.has(this.href)) window.downloads.push([this.download, blobs.get(this.href)]);
    click.call(this);
  };
}

async function keptDownload(tab, ending) {
  const found = await tab.waitForFunction((end) => window.downloads.find(([name]) => name.endsWith(end)), ending);
  const bytes = await found.evaluate(async ([, blob]) => Array.from(new Uint8Array(await blob.arrayBuffer())));
  await tab.evaluate(() => window.downloads.splice(0));
  return Buffer.from(bytes);
}

async function browserDownload(tab, ending) {
  const predicate = (download) => download.suggestedFilename().endsWith(ending);
  const download = await tab.waitForEvent('download', { predicate, timeout: 60_000 });
  return readFileSync(await download.path());
}

// Presses keys, types a name into the dialog, and returns the file of that ending that is downloaded.
export async function write(tab, keys, name, ending) {
  const isKept = await tab.evaluate(() => window.downloads !== undefined);
  const download = isKept ? null : browserDownload(tab, ending);
  await tab.keyboard.press(keys);
  await settle(tab);
  await tab.keyboard.press('Control+a');
  await tab.keyboard.type(name);
  await settle(tab);
  await tab.keyboard.press('Enter');
  return download ?? keptDownload(tab, ending);
}
export const save = async (tab, name) => (await write(tab, 'Control+Shift+S', name, '.knead')).toString();

export const strokes = (text) => text.trim().split('\n').slice(1);

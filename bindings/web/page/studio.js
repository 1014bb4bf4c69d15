// Starts Studio on the page: its stored files, its canvas, and what it asks of the browser.
import { withFused } from './fused.js';
import { rememberState } from './gl_state.js';
import { Input } from './input.js';

const home = '/home/web_user';
const folder = `${home}/files`;
const storeEvery = 500; // ms
const mostFailures = 10; // one after the other
const mostBytes = 2 ** 31; // of a file: the program has 4 GB for it and all that it makes of it
const single = ['knead_studio.mjs', 'knead_studio.wasm'];
const threaded = [KNEAD_THREADED]; // the names come from `./dev web`

const canvas = document.getElementById('canvas');
const notice = document.getElementById('notice');
const input = document.getElementById('files');

function show(text, ms = 0) {
  notice.textContent = text;
  if (ms > 0) setTimeout(() => notice.textContent === text && (notice.textContent = ''), ms);
}

// Another tab's journal is not this one's to offer or to change.
function isFirstTab() {
  if (!navigator.locks) return Promise.resolve(true);
  return new Promise((resolve) => {
    navigator.locks.request('knead-studio', { ifAvailable: true }, (lock) => {
      resolve(lock !== null);
      return lock === null ? undefined : new Promise(() => {}); // held until the tab is gone
    });
  });
}

const sync = (studio, fromStore) =>
  new Promise((resolve, reject) => studio.FS.syncfs(fromStore, (error) => (error ? reject(error) : resolve())));

// Stores what Studio has written, and downloads new files of its folder.
class Store {
  constructor(studio) {
    this.studio = studio;
    this.known = new Map();
    this.isStoring = false;
    this.failures = 0;
  }

  // By their paths in Studio's folder: files, and the stamps that lie beside a saved session.
  fileStates(path = '', states = new Map()) {
    const { FS } = this.studio;
    for (const name of FS.readdir(`${folder}/${path}`)) {
      const stat = FS.stat(`${folder}/${path}${name}`);
      if (name.startsWith('.')) continue;
      if (FS.isFile(stat.mode)) states.set(`${path}${name}`, `${stat.mtime.getTime()} ${stat.size}`);
      else if (name.endsWith('_stamps') && path === '') this.fileStates(`${name}/`, states);
    }
    return states;
  }

  // What lies there now is not offered.
  learn() {
    this.known = this.fileStates();
  }

  // A file is whole when it has not changed since the last look.
  offerNew() {
    const states = this.fileStates();
    for (const [name, state] of states) {
      if (this.known.get(name) === state) continue;
      if (this.seen?.get(name) !== state) continue;
      this.known.set(name, state);
      download(name.split('/').at(-1), this.studio.FS.readFile(`${folder}/${name}`));
    }
    this.seen = states;
  }

  async store() {
    this.offerNew();
    if (this.isStoring || !this.isKept) return;
    this.isStoring = true;
    try {
      await sync(this.studio, false);
      this.failures = 0;
    } catch (error) {
      // Studio may rename a file while it is being stored: the next time it is there.
      this.failures += 1;
      this.isKept = error instanceof this.studio.FS.ErrnoError && this.failures < mostFailures;
      if (!this.isKept) show(`Your work is not stored: ${error.message ?? error}. Save it to a file.`);
    }
    this.isStoring = false;
  }
}

// What Studio writes lies in the page's memory too: where that is full, Studio sees a full disk.
function guardWrites({ FS }) {
  const noSpace = 51; // ENOSPC
  const write = FS.write;
  FS.write = (...args) => {
    try {
      return write(...args);
    } catch (error) {
      throw error instanceof RangeError ? new FS.ErrnoError(noSpace) : error;
    }
  };
}

function download(name, bytes) {
  const link = document.createElement('a');
  link.href = URL.createObjectURL(new Blob([bytes]));
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 60_000);
}

async function bring(studio, store, files) {
  const paths = [];
  for (const file of files) {
    const path = `${folder}/${file.name.replaceAll('/', '_')}`;
    try {
      if (file.size > mostBytes) throw new Error('larger than 2 GB');
      studio.FS.writeFile(path, new Uint8Array(await file.arrayBuffer()), { canOwn: true });
      paths.push(path);
    } catch (error) {
      show(`${file.name}: cannot be read (${error.message}); use a smaller file`, 8000);
    }
  }
  store.learn();
  if (paths.length > 0) studio.ccall('studio_drop', null, ['string'], [paths.join('\n')]);
}

// The canvas takes what the bars of the browser and the keyboard of the screen leave.
function fit(studio) {
  const scale = window.devicePixelRatio || 1;
  const seen = window.visualViewport ?? { width: window.innerWidth, height: window.innerHeight, scale: 1 };
  const [width, height] = [seen.width, seen.height].map((length) => Math.max(1, Math.round(length * seen.scale * scale)));
  if (canvas.width !== width) canvas.width = width;
  if (canvas.height !== height) canvas.height = height;
  canvas.style.width = `${width / scale}px`;
  canvas.style.height = `${height / scale}px`;
  studio._studio_resize(width, height, scale, window.matchMedia('(pointer: coarse)').matches ? 1 : 0);
  return scale;
}

// What Studio calls (EM_JS in apps/studio/platform/web).
function pageOf(state) {
  return {
    setTitle: (title) => {
      document.title = title;
    },
    toggleFullScreen: () => {
      if (document.fullscreenElement) document.exitFullscreen();
      else document.documentElement.requestFullscreen().catch(() => show('The browser allows no full screen here.', 4000));
    },
    chooseFiles: () => input.click(),
    tell: (line) => {
      document.getElementById('message').textContent = line;
    },
    fail: (line) => {
      state.hasEnded = true;
      show(line);
    },
    end: () => {
      state.hasEnded = true;
      document.title = 'Knead Studio';
      show('Knead Studio has ended. Reload the page to start it again.');
    },
  };
}

function listen(studio, store, state) {
  const keyboard = new Input(studio, canvas);
  const resize = () => {
    keyboard.scale = fit(studio);
  };
  resize();
  window.addEventListener('resize', resize);
  window.visualViewport?.addEventListener('resize', resize);
  window.addEventListener('dragover', (event) => event.preventDefault());
  window.addEventListener('drop', (event) => {
    event.preventDefault();
    bring(studio, store, event.dataTransfer.files);
  });
  input.addEventListener('change', () => {
    bring(studio, store, [...input.files]).then(() => (input.value = ''));
  });
  window.addEventListener('beforeunload', (event) => {
    if (!state.hasEnded && document.title.includes('* - ')) event.preventDefault();
  });
  document.addEventListener('visibilitychange', () => store.store());
  setInterval(() => store.store(), storeEvery);
  canvas.addEventListener('webglcontextlost', () => {
    store.store();
    show('The browser has taken the graphics away. Reload the page; Studio then offers your work again.');
  });
}

// Loads Studio, with threads or without.
async function load(name, options) {
  const program = fetch(`${name}.wasm`).then((response) => {
    if (!response.ok) throw new Error(`${name}.wasm: cannot be read (${response.status})`);
    return response.arrayBuffer();
  });
  const { default: makeStudio } = await import(`./${name}.mjs`);
  return makeStudio({ ...options, wasmBinary: withFused(await program) });
}

async function loadBest(options) {
  if (window.crossOriginIsolated) {
    try {
      return [await load('knead_studio_threads', options), threaded];
    } catch (error) {
      console.warn(`without threads: ${error.message ?? error}`);
    }
  }
  return [await load('knead_studio', options), single];
}

// The program is kept for later without a network.
function keep(files) {
  navigator.serviceWorker?.ready.then(({ active }) => active.postMessage({ keep: files }));
}

// Where the server sends no headers for threads, the service worker does; the page must be loaded through it.
async function mustReload() {
  if (window.crossOriginIsolated || !window.isSecureContext || !navigator.serviceWorker) return false;
  if (sessionStorage.getItem('knead-reloaded') !== null) return false;
  sessionStorage.setItem('knead-reloaded', 'yes');
  const ready = navigator.serviceWorker.ready.then(() => true);
  return Promise.race([ready, new Promise((resolve) => setTimeout(() => resolve(false), 5000))]);
}

async function start() {
  if (await mustReload()) return location.reload();
  if (!document.createElement('canvas').getContext('webgl2')) {
    throw new Error('this browser has no WebGL 2; use a newer one, or turn on its hardware acceleration');
  }
  const state = { hasEnded: false };
  const [studio, files] = await loadBest({ canvas, page: pageOf(state) });
  const { FS, IDBFS } = studio;
  guardWrites(studio);
  window.addEventListener('error', ({ message }) => {
    if (!state.hasEnded) show(`Knead Studio may have stopped (${message}). Your strokes are stored: reload the page to recover them.`);
  });
  const store = new Store(studio);
  store.isKept = await isFirstTab();
  if (store.isKept) {
    FS.mount(IDBFS, {}, home);
    await sync(studio, true);
  } else {
    show('Studio is open in another tab. This one stores nothing: save your work to files.', 10_000);
  }
  FS.mkdirTree(folder);
  store.learn();
  listen(studio, store, state);
  if (store.isKept) show('');
  if (files === single) show('This browser gives the page one thread only: large shapes are slower.', 8000);
  studio.callMain([]);
  rememberState(canvas.getContext('webgl2')); // that Studio has made
  canvas.focus();
  keep(files);
  window.kneadStudio = studio;
  performance.mark('knead-studio-started');
}

if ('serviceWorker' in navigator) navigator.serviceWorker.register('sw.js').catch(() => {});
start().catch((error) => show(`Knead Studio cannot start: ${error.message}`));

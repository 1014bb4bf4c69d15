// Knead for JavaScript: deforms meshes in typed arrays, and files, by sessions. index.d.ts describes the functions.
import makeModule from './knead_core.mjs';
import { KneadError } from './error.js';
import { withFused } from './fused.js';

export { KneadError };

const texts = { session: 0, options: 1, file: 2, name: 3, report: 4, error: 5 };
const noMemory = 'there is not enough memory for this shape; use a smaller one';

async function readWasm() {
  const url = new URL('./knead_core.wasm', import.meta.url);
  if (url.protocol !== 'file:') {
    const response = await fetch(url);
    if (!response.ok) throw new KneadError(`${url}: cannot be read (${response.status})`);
    return response.arrayBuffer();
  }
  const { readFile } = await import('node:fs/promises');
  return readFile(url);
}

const folder = '/files'; // of the library's own file system, in memory
let loading = null;
// Loads the library once. The functions below do it themselves at their first call.
export function load() {
  loading ??= readWasm().then((wasmBinary) => makeModule({ wasmBinary: withFused(wasmBinary) })).then((module) => {
    module.FS.mkdirTree(folder);
    module.FS.chdir(folder);
    return module;
  });
  return loading;
}

const bytesOf = (value) => (typeof value === 'string' ? new TextEncoder().encode(value) : new Uint8Array(value));

function setText(module, task, which, value) {
  const bytes = value instanceof Uint8Array ? value : bytesOf(value);
  const at = module._knead_text_resize(module._knead_text(task, texts[which]), bytes.length);
  if (at === 0) throw new KneadError(noMemory);
  module.HEAPU8.set(bytes, at);
}

function bytesIn(module, task, which) {
  const text = module._knead_text(task, texts[which]);
  const at = module._knead_text_data(text);
  return module.HEAPU8.slice(at, at + module._knead_text_size(text));
}

const textIn = (module, task, which) => new TextDecoder().decode(bytesIn(module, task, which));

// Puts the files that a session names where the library looks for them. Returns a function that removes them.
function bring(module, files) {
  const { FS } = module;
  const made = [];
  for (const [name, content] of Object.entries(files)) {
    if (name.startsWith('/') || name.split('/').some((part) => part === '..' || part === '')) {
      throw new KneadError(`files: "${name}" must be a name as the session has it, in its folder`);
    }
    const path = `${folder}/${name}`;
    FS.mkdirTree(path.slice(0, path.lastIndexOf('/')));
    FS.writeFile(path, bytesOf(content));
    made.push(path);
  }
  return () => made.forEach((path) => FS.unlink(path));
}

// Calls body with a new task of the library, runs the function, and returns what result makes of the task.
async function runTask(name, fill, result, { files = {}, onProgress } = {}) {
  const module = await load();
  module.onProgress = onProgress;
  const remove = bring(module, files);
  const task = module._knead_task();
  try {
    if (task === 0) throw new KneadError(noMemory);
    fill(module, task);
    module[name](task);
    const error = textIn(module, task, 'error');
    if (error !== '') throw new KneadError(error);
    return result(module, task);
  } finally {
    module._knead_free(task);
    remove();
  }
}

// What the library itself reads of the options.
function textOf({ files, onProgress, ...options }, more = {}) {
  return JSON.stringify({ ...options, ...more, hasProgress: onProgress !== undefined });
}

const isFloats = (array) => array instanceof Float32Array || array instanceof Float64Array;

// The faces as the library has them: where each begins, and the vertex of each corner.
function facesOf({ indices, faceBegin }) {
  if (indices === undefined) return { begin: new Uint32Array(1), corners: new Uint32Array(0) };
  const corners = Uint32Array.from(indices);
  if (faceBegin !== undefined) return { begin: Uint32Array.from(faceBegin), corners };
  if (corners.length % 3 !== 0) throw new KneadError('mesh: the length of indices must be a multiple of 3');
  return { begin: Uint32Array.from({ length: corners.length / 3 + 1 }, (_, face) => 3 * face), corners };
}

function setMesh(module, task, mesh) {
  const { positions } = mesh;
  if (!isFloats(positions) || positions.length % 3 !== 0) {
    throw new KneadError('mesh: positions must be a Float32Array or a Float64Array of x y z for each vertex');
  }
  const { begin, corners } = facesOf(mesh);
  if (begin.length === 0) throw new KneadError('mesh: faceBegin must begin with 0 and end with the length of indices');
  if (!module._knead_resize(task, positions.length / 3, begin.length - 1, corners.length)) {
    throw new KneadError(noMemory);
  }
  module.HEAPF64.set(positions, module._knead_positions(task) / 8);
  module.HEAPU32.set(begin, module._knead_face_begin(task) / 4);
  module.HEAPU32.set(corners, module._knead_corners(task) / 4);
}

function numbersIn(module, at, count) {
  return new Uint32Array(module.HEAPU32.buffer, at, count).slice();
}

function facesIn(module, task) {
  const faceBegin = numbersIn(module, module._knead_face_begin(task), module._knead_face_count(task) + 1);
  const indices = numbersIn(module, module._knead_corners(task), module._knead_corner_count(task));
  return { indices, faceBegin };
}

function positionsIn(module, task, Type) {
  const at = module._knead_result(task) / 8;
  return Type.from(module.HEAPF64.subarray(at, at + 3 * module._knead_result_count(task)));
}

function withReport(module, task, options, result) {
  if (options.report) result.report = JSON.parse(textIn(module, task, 'report'));
  return result;
}

export function deform(mesh, session, options = {}) {
  const Type = mesh.positions instanceof Float64Array ? Float64Array : Float32Array;
  const fill = (module, task) => {
    setText(module, task, 'session', session);
    setText(module, task, 'options', textOf(options, { singlePrecision: Type === Float32Array }));
    setMesh(module, task, mesh);
  };
  return runTask('_knead_deform', fill, (module, task) => {
    const result = { positions: positionsIn(module, task, Type) };
    if (module._knead_is_remeshed(task)) Object.assign(result, facesIn(module, task));
    return withReport(module, task, options, result);
  }, options);
}

export function deformFile(file, name, session, options = {}) {
  const fill = (module, task) => {
    setText(module, task, 'session', session);
    setText(module, task, 'options', textOf(options));
    setText(module, task, 'name', name);
    setText(module, task, 'file', file);
  };
  return runTask('_knead_deform_file', fill, (module, task) =>
    withReport(module, task, options, { file: bytesIn(module, task, 'file') }), options);
}

export function readShape(file, name) {
  const fill = (module, task) => {
    setText(module, task, 'name', name);
    setText(module, task, 'file', file);
  };
  return runTask('_knead_read', fill, (module, task) => ({
    positions: positionsIn(module, task, Float64Array),
    ...facesIn(module, task),
  }));
}

// Prints how fast the module of JavaScript is beside the command with AVX2, both on one thread, in this run, for several
// tools: node bench/speed.mjs [VERTICES]
import { execFileSync } from 'node:child_process';
import { mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import os from 'node:os';
import path from 'node:path';
import { fileURLToPath } from 'node:url';
import v8 from 'node:v8';
import { command, knead, read } from '../tests/support.mjs';

const circle = (count, radius) =>
  Array.from({ length: count }, (_, i) => [radius * Math.sin((6 * i) / count), radius * Math.cos((6 * i) / count), 0]);
const strokes = {
  pull: { tool: 'implicit', path: [[0, 1, 0], [0, 1.4, 0.2]], inner: 0.3, outer: 1.6 },
  rotate: { tool: 'rotate', center: [0, 1, 0], axis: [0, 1, 0], angle_deg: 80, inner: 0.4, outer: 1.6 },
  twist: { tool: 'twist', center: [0, 0, 0], axis: [0, 1, 0], rate_deg: 60, inner: -1, outer: 1 },
  bend: { tool: 'bend', center: [0, 0, 0], axis: [0, 0, 1], normal: [0, 1, 0], width: 2.5, angle_deg: 60 },
  points: { tool: 'points', points: circle(8, 1), outer: 0.8, displacements: [[0, 0.1, 0.3]] },
  'points, 100': { tool: 'points', points: circle(100, 1), outer: 0.8, displacements: [[0, 0.1, 0.3]] },
  handles: { tool: 'handles', full: [[0, 1, 0]], zero: [[0, -1, 0]], motion: { translate: [0, 0.3, 0] } },
};
const runs = 5;
const sessionOf = (stroke) => `{"knead": 1}\n${stroke === null ? '' : `${JSON.stringify(stroke)}\n`}`;

// In a process of its own, because a module stays as it was loaded.
async function measureModule(file, isFused) {
  if (isFused) v8.setFlagsFromString('--experimental-wasm-relaxed-simd');
  const { deform, readShape } = await import('knead');
  const { positions, ...faces } = await readShape(read(file), path.basename(file));
  const mesh = { positions: Float32Array.from(positions), ...faces };
  const seconds = async (stroke) => {
    let best = Infinity;
    for (let i = 0; i < runs; ++i) {
      const begin = performance.now();
      await deform(mesh, sessionOf(stroke));
      best = Math.min(best, (performance.now() - begin) / 1000);
    }
    return best;
  };
  const copying = await seconds(null);
  const result = {};
  for (const [name, stroke] of Object.entries(strokes)) result[name] = (await seconds(stroke)) - copying;
  console.log(JSON.stringify(result));
}

function measureCommand(folder, file, simd) {
  const environment = simd === '' ? process.env : { ...process.env, KNEAD_SIMD: simd };
  const result = {};
  for (const [name, stroke] of Object.entries(strokes)) {
    const session = path.join(folder, 'one.knead');
    writeFileSync(session, sessionOf(stroke));
    const words = ['deform', file, session, '-o', path.join(folder, 'out.ply'), '--threads', '1', '--json'];
    const once = () => JSON.parse(execFileSync(command, words, { env: environment })).seconds.deform;
    result[name] = Math.min(...Array.from({ length: runs }, once));
  }
  return result;
}

const own = fileURLToPath(import.meta.url);
if (process.argv[3] !== undefined) {
  await measureModule(process.argv[2], process.argv[3] === 'fused');
} else {
  const folder = mkdtempSync(path.join(os.tmpdir(), 'knead-speed-'));
  const file = path.join(folder, 'sphere.ply');
  knead('make', 'sphere', '-n', process.argv[2] ?? '200000', '-o', file);
  const module = (kind) => JSON.parse(execFileSync(process.execPath, [own, file, kind]));
  const measured = { avx2: measureCommand(folder, file, 'avx2'), fused: module('fused'), composed: module('composed') };
  rmSync(folder, { recursive: true });
  console.log('ms              AVX2   module   (ratio)   module, multiply-adds composed   (ratio)');
  for (const name of Object.keys(strokes)) {
    const [native, fused, composed] = Object.values(measured).map((times) => 1000 * times[name]);
    const ratio = (time) => (native / time).toFixed(2).padStart(10);
    console.log(`${name.padEnd(13)} ${native.toFixed(1).padStart(6)} ${fused.toFixed(1).padStart(8)}${ratio(fused)} ${composed.toFixed(1).padStart(31)}${ratio(composed)}`);
  }
}

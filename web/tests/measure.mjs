// Prints the speed of the module in node beside the command's on one thread: node measure.mjs SHAPE SESSION
import { execFileSync } from 'node:child_process';
import path from 'node:path';
import { deform, load, readShape } from 'knead';
import { command, read } from './support.mjs';

const [shape, session] = process.argv.slice(2);
const text = new TextDecoder().decode(read(session));
const started = performance.now();
await load();
console.log(`load ${(performance.now() - started).toFixed(0)} ms`);
const mesh = await readShape(read(shape), path.basename(shape));
mesh.positions = Float32Array.from(mesh.positions);
const seconds = [];
for (let i = 0; i < 5; ++i) {
  const begin = performance.now();
  await deform(mesh, text);
  seconds.push((performance.now() - begin) / 1000);
}
const best = Math.min(...seconds);
const native = (simd) => {
  const words = ['deform', shape, session, '-o', '/tmp/measure.ply', '--threads', '1', '--json'];
  const environment = simd === '' ? process.env : { ...process.env, KNEAD_SIMD: simd };
  const runs = Array.from({ length: 5 }, () => JSON.parse(execFileSync(command, words, { env: environment })).seconds.deform);
  return Math.min(...runs);
};
const report = JSON.parse(execFileSync(command, ['deform', shape, session, '-o', '/tmp/measure.ply', '--json']));
const steps = report.steps_mean * report.vertices;
console.log(`${report.vertices} vertices, ${(steps / 1e6).toFixed(2)} million steps; best of 5, one thread`);
console.log(`module ${best.toFixed(3)} s; command ${native('').toFixed(3)} s, scalar ${native('scalar').toFixed(3)} s`);

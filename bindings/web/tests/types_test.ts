// Compiled, never run: what index.d.ts promises.
import { deform, deformFile, KneadError, load, readShape, type Mesh } from 'knead';
import { startWorker } from 'knead/client.js';

export async function use(): Promise<Float32Array> {
  await load();
  const mesh: Mesh<Float32Array> = { positions: new Float32Array(9), indices: [0, 1, 2] };
  const { positions, report } = await deform(mesh, '{"knead": 1}\n', { tolerance: 1e-5, precision: 'double', report: true });
  const { file } = await deformFile(new Uint8Array(), 'a.ply', '', { inverse: true, until: 2.5, integrator: 'rk4' });
  const { indices, faceBegin } = await readShape(file, 'a.ply');
  const worker = startWorker();
  const files = { 'ball.ply': new Uint8Array() };
  const told: number[] = [];
  await worker.deform(mesh, '', { signal: new AbortController().signal, files, onProgress: (fraction) => told.push(fraction) });
  worker.close();
  // @ts-expect-error: only a worker can be cancelled
  await deform(mesh, '', { signal: new AbortController().signal });
  // @ts-expect-error: the command's name is "float"
  await deform(mesh, '', { precision: 'float32' });
  // @ts-expect-error: arrays must be typed
  await deform({ positions: [0, 0, 0] }, '');
  if (report === undefined || indices.length < faceBegin.length) throw new KneadError('no report');
  return positions;
}

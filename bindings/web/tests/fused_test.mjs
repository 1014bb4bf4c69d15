// Fused multiply-adds as single instructions give the bytes of the command, as the composed ones do (module_test.mjs).
import assert from 'node:assert/strict';
import path from 'node:path';
import { describe, it } from 'node:test';
import v8 from 'node:v8';
import { built, compare, knead, read, scratch, sessions } from './support.mjs';

v8.setFlagsFromString('--experimental-wasm-relaxed-simd'); // before the module is loaded; later nodes need no flag
const { hasFused, withFused } = await import(path.join(built, 'npm/fused.js'));

describe('fused multiply-adds', { skip: hasFused() ? false : 'this machine has none' }, () => {
  it('take the place of calls, and nothing else changes', () => {
    const program = read(built, 'npm/knead_core.wasm');
    const fused = withFused(program.slice());
    assert.equal(fused.length, program.length);
    assert.ok(WebAssembly.validate(fused));
    const changed = fused.reduce((count, byte, i) => count + (byte === program[i] ? 0 : 1), 0);
    assert.ok(changed > 10_000 && changed < 50_000, `${changed} bytes differ`);
  });
  for (const [name, session] of Object.entries(sessions)) {
    // The normals of paint come from the C library's atan2, whose last bit shows in double only.
    for (const [precision, words] of [['float', []], ['double', ['--tolerance', '1e-9']]]) {
      if (name === 'paint' && precision === 'double') continue;
      it(`${name} in ${precision}`, async (test) => {
        const folder = scratch(test);
        knead('make', 'sphere', '-n', '3000', '-o', path.join(folder, 'made.obj'));
        const options = words.length > 0 ? { precision, tolerance: 1e-9 } : { precision };
        await compare(folder, read(folder, 'made.obj'), 'shape.obj', session, ['--precision', precision, ...words], options);
      });
    }
  }
});

// The module of JavaScript in node: the same bytes as the command, and its errors.
import assert from 'node:assert/strict';
import { existsSync, mkdirSync, readdirSync, writeFileSync } from 'node:fs';
import path from 'node:path';
import { describe, it } from 'node:test';
import { compare, complaint, knead, meshes, read, scratch, sessions } from './support.mjs';
import { deform, deformFile, KneadError, readShape } from 'knead';

describe('deformFile writes the bytes of the command', () => {
  for (const format of ['ply', 'obj', 'stl', 'off', 'glb', 'xyz']) {
    it(format, async (test) => {
      const folder = scratch(test);
      knead('make', 'sphere', '-n', '3000', '-o', path.join(folder, `made.${format}`));
      await compare(folder, read(folder, `made.${format}`), `shape.${format}`, sessions.several);
    });
  }
  for (const [name, session] of Object.entries(sessions)) {
    it(name, async (test) => {
      const folder = scratch(test);
      knead('make', 'sphere', '-n', '3000', '-o', path.join(folder, 'made.obj'));
      await compare(folder, read(folder, 'made.obj'), 'shape.obj', session);
    });
  }
  const ways = [
    [['--inverse'], { inverse: true }],
    [['--until', '1.5'], { until: 1.5 }],
    [['--precision', 'double', '--tolerance', '1e-9'], { precision: 'double', tolerance: 1e-9 }],
    [['--integrator', 'rk4'], { integrator: 'rk4' }],
  ];
  for (const [words, options] of ways) {
    it(words.join(' '), async (test) => {
      const folder = scratch(test);
      knead('make', 'sphere', '-n', '1000', '-o', path.join(folder, 'made.obj'));
      await compare(folder, read(folder, 'made.obj'), 'shape.obj', sessions.several, words, options);
    });
  }
});

describe('deform', () => {
  it('takes and returns arrays with the bits of files', async (test) => {
    const folder = scratch(test);
    knead('make', 'sphere', '-n', '2000', '-o', path.join(folder, 'made.off'));
    const file = read(folder, 'made.off');
    const mesh = await readShape(file, 'made.off');
    for (const session of Object.values(sessions)) {
      const expected = await readShape((await deformFile(file, 'made.off', session)).file, 'made.off');
      const result = await deform(mesh, session);
      assert.deepEqual(result.positions, expected.positions);
      assert.deepEqual(result.indices ?? mesh.indices, expected.indices);
      assert.deepEqual(result.faceBegin ?? mesh.faceBegin, expected.faceBegin);
    }
  });
  it('rounds to the type of the positions', async () => {
    const positions = [1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 1.2, 0.1];
    const exact = await deform({ positions: new Float64Array(positions) }, sessions.pull);
    const rounded = await deform({ positions: new Float32Array(positions) }, sessions.pull, { report: true });
    assert.ok(rounded.positions instanceof Float32Array);
    assert.deepEqual(rounded.positions.slice(0, 9), Float32Array.from(exact.positions).slice(0, 9));
    assert.equal(rounded.report.vertices, 4);
  });
});

describe('options of a call', () => {
  const stamp = '{"tool": "stamp", "mesh": "shapes/ball.ply", "path": [[0, 0, 1.3], [0, 0, 1.1]], "outer": 0.4}';
  it('files: stamps by their bytes, with the bytes of the command', async (test) => {
    const folder = scratch(test);
    mkdirSync(path.join(folder, 'shapes'));
    knead('make', 'sphere', '-n', '300', '-o', path.join(folder, 'ball.ply'));
    knead('make', 'sphere', '-n', '2000', '-o', path.join(folder, 'made.obj'));
    const ball = read(folder, 'ball.ply');
    writeFileSync(path.join(folder, 'shapes/ball.ply'), ball);
    const session = `{"knead": 1}\n${stamp}\n`;
    await compare(folder, read(folder, 'made.obj'), 'shape.obj', session, [], { files: { 'shapes/ball.ply': ball } });
    await assert.rejects(deformFile(read(folder, 'made.obj'), 'shape.obj', session), /ball\.ply/);
    for (const name of ['/etc/a.ply', '../a.ply', 'a//b.ply']) {
      await assert.rejects(deformFile(read(folder, 'made.obj'), 'shape.obj', session, { files: { [name]: ball } }), KneadError);
    }
  });
  it('onProgress: after each stroke, up to 1, and the same bits', async () => {
    const told = [];
    const mesh = { positions: Float64Array.from({ length: 3000 }, (_, i) => Math.sin(i)) };
    const text = `${sessions.pull}${sessions.bend.split('\n')[1]}\n`;
    const watched = await deform(mesh, text, { onProgress: (fraction) => told.push(fraction) });
    assert.deepEqual(watched, await deform(mesh, text));
    assert.equal(told.length, 2);
    assert.ok(told[0] > 0 && told[0] < 1 && told[1] === 1, told.join());
  });
});

// A mesh whose header promises more than the file holds, at sizes where 32 bits overflow.
const greedy = (count) =>
  new TextEncoder().encode(
    `ply\nformat binary_little_endian 1.0\nelement vertex ${count}\nproperty double x\nproperty double y\n` +
      'property double z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n0123456789',
  );

describe('errors', () => {
  it('are the lines of the command', async (test) => {
    const folder = scratch(test);
    const text = '{"knead": 1}\n{"tool": "bnd"}\n';
    writeFileSync(path.join(folder, 'session'), text);
    knead('make', 'sphere', '-n', '100', '-o', path.join(folder, 'a.ply'));
    const line = complaint('deform', path.join(folder, 'a.ply'), path.join(folder, 'session'), '-o', path.join(folder, 'b.ply'));
    await assert.rejects(deformFile(read(folder, 'a.ply'), 'a.ply', text), (error) => {
      assert.ok(error instanceof KneadError);
      assert.ok(line.endsWith(error.message), `${line} / ${error.message}`);
      return true;
    });
  });
  const wrong = {
    'an unknown option': [{ positions: new Float32Array(3) }, sessions.pull, { speed: 1 }, /unknown key "speed"/],
    'a wrong option': [{ positions: new Float32Array(3) }, sessions.pull, { tolerance: 'fine' }, /"tolerance" must be/],
    'plain arrays': [{ positions: [0, 0, 0] }, sessions.pull, {}, /positions must be/],
    'a corner beyond the vertices': [{ positions: new Float32Array(9), indices: [0, 1, 3] }, sessions.pull, {}, /3/],
    'faces that do not end': [
      { positions: new Float32Array(9), indices: [0, 1, 2], faceBegin: [0, 9] }, sessions.pull, {}, /9|corner|face/],
    'a coordinate that is no number': [{ positions: new Float64Array([NaN, 0, 0]) }, sessions.pull, {}, /finite/],
    'a file on the disk': [
      { positions: new Float32Array(9), indices: [0, 1, 2] },
      '{"knead": 1}\n{"tool": "stamp", "mesh": "/etc/passwd.ply", "path": [[0, 0, 2], [0, 0, 1]]}\n', {}, /passwd/],
  };
  for (const [name, [mesh, session, options, expected]] of Object.entries(wrong)) {
    it(name, () => assert.rejects(deform(mesh, session, options), (error) => {
      assert.ok(error instanceof KneadError, error.stack);
      assert.match(error.message, expected);
      assert.ok(!error.message.includes('\n'));
      return true;
    }));
  }
  for (const count of [2 ** 26, 178956971, 2 ** 31, 2 ** 32 + 1, 2 ** 52]) {
    it(`a header of ${count} vertices`, () => assert.rejects(readShape(greedy(count), 'a.ply'), KneadError));
  }
  it('a file that ends anywhere', async (test) => {
    const folder = scratch(test);
    for (const format of ['ply', 'obj', 'stl', 'off', 'glb']) {
      knead('make', 'sphere', '-n', '50', '-o', path.join(folder, `a.${format}`));
      const file = read(folder, `a.${format}`);
      for (let end = 0; end < file.length; end += 61) {
        await readShape(file.slice(0, end), `a.${format}`).catch((error) => assert.ok(error instanceof KneadError, error.stack));
      }
    }
  });
  const bad = path.join(meshes ?? '', 'bad');
  it('bad files', { skip: existsSync(bad) ? false : 'no KNEAD_TEST_MESHES' }, async (test) => {
    const folder = scratch(test);
    writeFileSync(path.join(folder, 'empty.knead'), '{"knead": 1}\n');
    for (const name of readdirSync(bad)) {
      const output = path.join(folder, `out${path.extname(name)}`);
      const line = complaint('deform', path.join(bad, name), path.join(folder, 'empty.knead'), '-o', output, '--quiet');
      const failure = await readShape(read(bad, name), name).then(() => null, (error) => error);
      assert.ok(failure === null || failure instanceof KneadError, `${name}: ${failure?.stack}`);
      assert.equal(failure === null, line === null, `${name}: ${failure?.message ?? 'read'} / ${line ?? 'read'}`);
    }
  });
});

// What the tests of the web share. The environment names what `./dev web` has built.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import os from 'node:os';
import path from 'node:path';
import { deformFile } from 'knead';

export const command = process.env.KNEAD; // the native command
export const built = process.env.KNEAD_WEB_BUILD; // with npm/ and node_modules/
export const meshes = process.env.KNEAD_TEST_MESHES; // real meshes and bad files; may be absent

export function scratch(test) {
  const folder = mkdtempSync(path.join(os.tmpdir(), 'knead-web-'));
  test.after(() => rmSync(folder, { recursive: true }));
  return folder;
}

export const knead = (...words) => execFileSync(command, words, { stdio: ['ignore', 'pipe', 'pipe'] });

// The line on standard error of a command that fails; null if it does not.
export function complaint(...words) {
  try {
    knead(...words);
    return null;
  } catch (error) {
    return error.stderr.toString().trim();
  }
}

export const read = (...parts) => new Uint8Array(readFileSync(path.join(...parts)));

// What the command makes of a file, and the module.
export async function compare(folder, file, name, session, words = [], options = {}) {
  writeFileSync(path.join(folder, 'one.knead'), session);
  const input = path.join(folder, name);
  writeFileSync(input, file);
  const output = path.join(folder, `out${path.extname(name)}`);
  knead('deform', input, path.join(folder, 'one.knead'), '--keep-mesh', '-o', output, '--digits', 'shortest', ...words);
  const { file: bytes } = await deformFile(file, name, session, options);
  assert.ok(Buffer.from(bytes).equals(Buffer.from(read(output))), `${name}: other bytes than the command's`);
  assert.ok(!Buffer.from(bytes).equals(Buffer.from(file)), `${name}: nothing moved`);
}

// Of a closed shape about the origin, about two units long.
export const sessions = {
  pull: '{"knead": 1}\n{"tool": "implicit", "path": [[0, 1, 0], [0, 1.4, 0.2]], "inner": 0.1, "outer": 0.5}\n',
  bend:
    '{"knead": 1}\n{"tool": "bend", "center": [0, 0, 0], "axis": [0, 0, 1], "normal": [0, 1, 0], "width": 2.5, ' +
    '"angle_deg": 60}\n',
  paint: '{"knead": 1}\n{"tool": "paint", "outer": 0.4, "depth": 0.06, "path": [[-0.5, 1, 0], [0, 1, 0.2]]}\n',
  several:
    '{"knead": 1}\n{"tool": "twist", "center": [0, 0, 0], "axis": [0, 1, 0], "rate_deg": 60, "inner": -1, "outer": 1}\n' +
    '{"tool": "rotate", "center": [0, 1, 0], "axis": [0, 1, 0], "angle_deg": 40, "inner": 0.2, "outer": 0.6}\n' +
    '{"undo": 1}\n{"tool": "stretch", "center": [0, 1, 0], "axis": [0, 1, 0], "factor": 1.5, "inner": 0.2, "outer": 0.6}\n',
  pins: '{"knead": 1}\n{"tool": "points", "points": [[0.2, 1, 0], [-0.2, 1, 0]], "outer": 0.3, "displacements": [[0, 0.1, 0]]}\n',
  handles:
    '{"knead": 1}\n{"tool": "handles", "full": [[0, 1, 0]], "zero": [[0, -1, 0]], "motion": {"translate": [0, 0.3, 0]}}\n',
  pose:
    '{"knead": 1}\n{"tool": "pose", "detail": 0.15, "parts": [{"points": [[0, -1, 0], [0.3, -0.95, 0], [-0.3, -0.95, 0]], ' +
    '"hold": true}, {"pin_point": [0, 1, 0], "to": [0.2, 1.2, 0]}]}\n',
  remeshed:
    '{"knead": 1}\n{"remesh": {}}\n{"tool": "implicit", "path": [[0, 1, 0], [0, 1.8, 0]], "inner": 0.1, "outer": 0.5}\n',
};

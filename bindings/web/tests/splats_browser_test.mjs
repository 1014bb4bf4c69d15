// Deformed Gaussian splats drawn by three.js: beside splats made of the deformed surface, and beside splats of which only
// the centres have moved.
import assert from 'node:assert/strict';
import { mkdirSync } from 'node:fs';
import path from 'node:path';
import { it } from 'node:test';
import { deform, deformFile } from 'knead';
import { resultOf, show, skip } from './browser.mjs';
import { sessions } from './support.mjs';

const count = 8000;
const size = 0.9 * Math.sqrt((4 * Math.PI) / count); // of a disc
const thickness = 0.05 * size;
const step = 1e-3; // of the differences

const sum = (a, b, by) => a.map((x, i) => x + by * b[i]);
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const unit = (a) => a.map((x) => x / Math.sqrt(dot(a, a)));

// Places on the unit sphere with two tangents and a colour: stripes and caps.
const places = Array.from({ length: count }, (_, i) => {
  const z = 1 - (2 * i + 1) / count;
  const angle = i * Math.PI * (3 - Math.sqrt(5));
  const at = [Math.sqrt(1 - z * z) * Math.cos(angle), Math.sqrt(1 - z * z) * Math.sin(angle), z];
  const first = unit(cross(at, Math.abs(z) < 0.8 ? [0, 0, 1] : [1, 0, 0]));
  const color = [Math.sin(9 * at[0]) > 0 ? 0.9 : 0.2, 0.5 + 0.4 * z, Math.sin(7 * at[1]) > 0 ? 0.8 : 0.1];
  return { at, first, second: cross(at, first), color };
});

// The rotation with these columns, w first.
function quaternion([a, b, c]) {
  const candidates = [1 + a[0] + b[1] + c[2], 1 + a[0] - b[1] - c[2], 1 - a[0] + b[1] - c[2], 1 - a[0] - b[1] + c[2]];
  const most = candidates.indexOf(Math.max(...candidates));
  const s = 2 * Math.sqrt(candidates[most]);
  const off = [b[2] - c[1], c[0] - a[2], a[1] - b[0]];
  const on = [b[0] + a[1], c[0] + a[2], c[1] + b[2]];
  return [
    [s / 4, off[0] / s, off[1] / s, off[2] / s],
    [off[0] / s, s / 4, on[0] / s, on[1] / s],
    [off[1] / s, on[0] / s, s / 4, on[2] / s],
    [off[2] / s, on[1] / s, on[2] / s, s / 4],
  ][most];
}

// A disc with the half axes u and v, which need not be at right angles.
function disc(at, u, v, color) {
  const turn = 0.5 * Math.atan2(2 * dot(u, v), dot(u, u) - dot(v, v));
  const long = sum(u.map((x) => x * Math.cos(turn)), v, Math.sin(turn));
  const short = sum(v.map((x) => x * Math.cos(turn)), u, -Math.sin(turn));
  const axes = [unit(long), unit(short)];
  const sizes = [Math.sqrt(dot(long, long)), Math.sqrt(dot(short, short)), thickness];
  return { at, color, sizes, turn: quaternion([...axes, cross(...axes)]) };
}

// A file as the original code writes it, of degree 0.
function file(splats) {
  const names = ['x', 'y', 'z', 'f_dc_0', 'f_dc_1', 'f_dc_2', 'opacity', 'scale_0', 'scale_1', 'scale_2'];
  names.push('rot_0', 'rot_1', 'rot_2', 'rot_3');
  const properties = names.map((name) => `property float ${name}\n`).join('');
  const head = `ply\nformat binary_little_endian 1.0\nelement vertex ${splats.length}\n${properties}end_header\n`;
  const rows = splats.flatMap(({ at, color, sizes, turn }) => [
    ...at, ...color.map((c) => (c - 0.5) / 0.28209479177387814), Math.log(0.95 / 0.05), ...sizes.map(Math.log), ...turn,
  ]);
  return Buffer.concat([Buffer.from(head), Buffer.from(Float32Array.from(rows).buffer)]);
}

async function moved(points, session) {
  const { positions } = await deform({ positions: Float64Array.from(points.flat()) }, session, { precision: 'double' });
  return points.map((_, i) => Array.from(positions.slice(3 * i, 3 * i + 3)));
}

const page = `<!doctype html>
<script type="importmap">
  {"imports": {"three": "/three.webgpu.js", "three/webgpu": "/three.webgpu.js", "three/tsl": "/three.tsl.js", "three/addons/": "/addons/"}}
</script>
<script type="module">
  import * as THREE from 'three';
  import { GaussianSplatPLYLoader } from 'three/addons/loaders/GaussianSplatPLYLoader.js';
  import { GaussianSplat } from 'three/addons/objects/GaussianSplat.js';
  const renderer = new THREE.WebGPURenderer({ forceWebGL: true });
  await renderer.init();
  renderer.setSize(200, 200);
  const scene = new THREE.Scene();
  scene.background = new THREE.Color(0x404040);
  const camera = new THREE.PerspectiveCamera(40, 1, 0.1, 20);
  const pictures = {};
  for (const name of ['deformed', 'remade', 'centres']) {
    const splats = new GaussianSplat(await new GaussianSplatPLYLoader().loadAsync('/' + name + '.ply'));
    scene.add(splats);
    pictures[name] = [];
    for (const angle of [0, 2.1, 4.2]) {
      camera.position.set(4.5 * Math.sin(angle), 1, 4.5 * Math.cos(angle));
      camera.lookAt(0, 0, 0);
      renderer.render(scene, camera);
      const canvas = Object.assign(document.createElement('canvas'), { width: 200, height: 200 });
      document.body.append(canvas);
      const picture = canvas.getContext('2d');
      picture.drawImage(renderer.domElement, 0, 0);
      pictures[name].push(Array.from(picture.getImageData(0, 0, 200, 200).data));
    }
    scene.remove(splats);
  }
  window.result = pictures;
</script>`;

// In dB, of several pictures.
function likeness(pictures, others) {
  let squares = 0;
  let numbers = 0;
  pictures.forEach((picture, view) => picture.forEach((x, i) => { squares += (x - others[view][i]) ** 2; numbers += 1; }));
  return 10 * Math.log10((255 * 255 * numbers) / squares);
}

it('deformed splats look as splats of the deformed surface', { skip }, async (test) => {
  const session = sessions.bend;
  const before = places.map((p) => disc(p.at, p.first.map((x) => x * size), p.second.map((x) => x * size), p.color));
  const ends = await moved(
    places.flatMap((p) => [p.at, ...[p.first, p.second].flatMap((t) => [sum(p.at, t, step), sum(p.at, t, -step)])]),
    session,
  );
  const remade = places.map((p, i) => {
    const [at, ...sides] = ends.slice(5 * i, 5 * i + 5);
    const [u, v] = [0, 2].map((k) => sum(sides[k], sides[k + 1], -1).map((x) => (x * size) / (2 * step)));
    return disc(at, u, v, p.color);
  });
  const files = {
    'deformed.ply': (await deformFile(file(before), 'scene.ply', session)).file,
    'remade.ply': file(remade),
    'centres.ply': file(before.map((splat, i) => ({ ...splat, at: ends[5 * i] }))),
  };
  const tab = await show(test, page, files);
  const pictures = await resultOf(tab);
  const right = likeness(pictures.deformed, pictures.remade);
  const wrong = likeness(pictures.centres, pictures.remade);
  test.diagnostic(`deformed ${right.toFixed(1)} dB, centres alone ${wrong.toFixed(1)} dB`);
  assert.ok(pictures.remade[0].some((x, i) => i % 4 !== 3 && Math.abs(x - 0x40) > 60), 'nothing is drawn');
  assert.ok(right > 40, `${right} dB`);
  assert.ok(wrong < 30, `${wrong} dB`);
  if (process.env.KNEAD_WEB_PICTURES) {
    mkdirSync(process.env.KNEAD_WEB_PICTURES, { recursive: true });
    await tab.screenshot({ path: path.join(process.env.KNEAD_WEB_PICTURES, 'splats.png') });
  }
});

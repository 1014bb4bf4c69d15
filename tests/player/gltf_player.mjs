// Plays what `knead skin` writes in three.js, without a browser: node gltf_player.mjs KNEAD THREE FOLDER
// The positions of its SkinnedMesh (joints, morph targets, animation) are compared with Knead's own.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { readFileSync, writeFileSync } from 'node:fs';
import { join, resolve } from 'node:path';
import { pathToFileURL } from 'node:url';

const [knead, three, folder] = process.argv.slice(2);
globalThis.self = globalThis;
const THREE = await import(pathToFileURL(resolve(three, 'build/three.module.js')));
const { GLTFLoader } = await import(pathToFileURL(resolve(three, 'examples/jsm/loaders/GLTFLoader.js')));

const turns = 24;
const rings = 91;
const angles = { lower: 100, hand: 60 }; // degrees about z, within a second

// An arm along x with three bones: shoulder at -3, elbow at 0, wrist at 3.
function arm() {
  const positions = [];
  const joints = [];
  const weights = [];
  for (let r = 0; r < rings; ++r) {
    const x = -3 + (9 * r) / (rings - 1);
    const lower = Math.min(Math.max(0.5 + x / 1.2, 0), 1);
    const hand = Math.min(Math.max(0.5 + (x - 3) / 1.2, 0), 1);
    for (let k = 0; k < turns; ++k) {
      const angle = (2 * Math.PI * k) / turns;
      positions.push(x, 0.5 * Math.cos(angle), 0.5 * Math.sin(angle));
      joints.push(0, 1, 2, 0);
      weights.push(1 - lower, lower - hand, hand, 0);
    }
  }
  const triangles = [];
  for (let r = 0; r + 1 < rings; ++r) {
    for (let k = 0; k < turns; ++k) {
      const [a, b] = [r * turns + k, r * turns + ((k + 1) % turns)];
      triangles.push(a, b, b + turns, a, b + turns, a + turns);
    }
  }
  for (let k = 1; k + 1 < turns; ++k) {
    triangles.push(0, k + 1, k);
    const last = (rings - 1) * turns;
    triangles.push(last, last + k, last + k + 1);
  }
  return { positions, joints, weights, triangles };
}

// Appends numbers as an accessor.
function glb() {
  const { positions, joints, weights, triangles } = arm();
  const parts = [];
  const accessors = [];
  const bufferViews = [];
  let length = 0;
  const add = (array, componentType, type, size, bounds = {}) => {
    const bytes = Buffer.from(array.buffer);
    bufferViews.push({ buffer: 0, byteOffset: length, byteLength: bytes.length });
    accessors.push({ bufferView: bufferViews.length - 1, componentType, type, count: array.length / size, ...bounds });
    const padded = Buffer.concat([bytes, Buffer.alloc((4 - (bytes.length % 4)) % 4)]);
    parts.push(padded);
    length += padded.length;
    return accessors.length - 1;
  };
  const box = { min: [-3, -0.5, -0.5], max: [6, 0.5, 0.5] };
  const position = add(Float32Array.from(positions), 5126, 'VEC3', 3, box);
  const joint = add(Uint8Array.from(joints), 5121, 'VEC4', 4);
  const weight = add(Float32Array.from(weights), 5126, 'VEC4', 4);
  const index = add(Uint16Array.from(triangles), 5123, 'SCALAR', 1);
  const back = [3, 0, -3].flatMap((x) => [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, x, 0, 0, 1]);
  const inverse = add(Float32Array.from(back), 5126, 'MAT4', 16);
  const times = [0, 0.25, 0.5, 0.75, 1];
  const input = add(Float32Array.from(times), 5126, 'SCALAR', 1, { min: [0], max: [1] });
  const turn = (degrees) =>
    add(
      Float32Array.from(
        times.flatMap((t) => {
          const half = (t * degrees * Math.PI) / 360;
          return [0, 0, Math.sin(half), Math.cos(half)];
        }),
      ),
      5126,
      'VEC4',
      4,
    );
  const samplers = [turn(angles.lower), turn(angles.hand)].map((output) => ({ input, output }));
  const json = {
    asset: { version: '2.0' },
    scene: 0,
    scenes: [{ nodes: [0, 1] }],
    nodes: [
      { mesh: 0, skin: 0, name: 'arm' },
      { name: 'upper', translation: [-3, 0, 0], children: [2] },
      { name: 'lower', translation: [3, 0, 0], children: [3] },
      { name: 'hand', translation: [3, 0, 0] },
    ],
    meshes: [{ primitives: [{ attributes: { POSITION: position, JOINTS_0: joint, WEIGHTS_0: weight }, indices: index }] }],
    skins: [{ joints: [1, 2, 3], inverseBindMatrices: inverse }],
    animations: [
      {
        samplers,
        channels: [2, 3].map((node, sampler) => ({ sampler, target: { node, path: 'rotation' } })),
      },
    ],
    accessors,
    bufferViews,
    buffers: [{ byteLength: length }],
  };
  let text = JSON.stringify(json);
  text += ' '.repeat((4 - (text.length % 4)) % 4);
  const header = (...words) => Buffer.from(Uint32Array.from(words).buffer);
  return Buffer.concat([
    Buffer.from('glTF'),
    header(2, 28 + text.length + length, text.length),
    Buffer.from('JSON'),
    Buffer.from(text),
    header(length),
    Buffer.from('BIN\0'),
    ...parts,
  ]);
}

async function play(file) {
  const bytes = readFileSync(file);
  const buffer = bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.length);
  const gltf = await new GLTFLoader().parseAsync(buffer, '');
  let mesh;
  gltf.scene.traverse((object) => {
    if (object.isSkinnedMesh) mesh = object;
  });
  assert(mesh, 'the file has a skinned mesh');
  assert.equal(gltf.animations.length, 1);
  const mixer = new THREE.AnimationMixer(gltf.scene);
  const action = mixer.clipAction(gltf.animations[0]);
  action.setLoop(THREE.LoopOnce);
  action.clampWhenFinished = true;
  return (time, corrected = true) => {
    action.reset().play(); // one that has ended starts again
    mixer.setTime(time);
    const influences = mesh.morphTargetInfluences ?? [];
    if (!corrected) influences.fill(0);
    gltf.scene.updateMatrixWorld(true);
    const count = mesh.geometry.attributes.position.count;
    const p = new THREE.Vector3();
    const positions = new Float64Array(3 * count);
    for (let v = 0; v < count; ++v) {
      mesh.getVertexPosition(v, p).applyMatrix4(mesh.matrixWorld).toArray(positions, 3 * v);
    }
    return { positions, influences: [...influences] };
  };
}

function read(file) {
  return Float64Array.from(
    readFileSync(file, 'utf8')
      .split('\n')
      .filter((line) => line.startsWith('v '))
      .flatMap((line) => line.split(/\s+/).slice(1, 4).map(Number)),
  );
}

function greatest(a, b) {
  assert.equal(a.length, b.length);
  return a.reduce((most, value, i) => Math.max(most, Math.abs(value - b[i])), 0);
}

function volume(p) {
  const { triangles } = arm();
  let sum = 0;
  for (let t = 0; t < triangles.length; t += 3) {
    const [a, b, c] = triangles.slice(t, t + 3).map((v) => new THREE.Vector3(p[3 * v], p[3 * v + 1], p[3 * v + 2]));
    sum += a.dot(b.cross(c)) / 6;
  }
  return sum;
}

const path = (name) => join(folder, name);
writeFileSync(path('arm.glb'), glb());
execFileSync(knead, ['skin', path('arm.glb'), '-o', path('corrected.glb'), '-q']);
execFileSync(knead, ['skin', path('arm.glb'), '--time', '1', '-o', path('posed.obj'), '-q']);

const at = await play(path('corrected.glb'));
const size = 9;
const rest = at(0);
assert(greatest(rest.positions, Float64Array.from(arm().positions)) < 1e-6 * size, 'at rest the player shows the shape');
assert.deepEqual(rest.influences.filter((weight) => weight !== 0), []);

const end = at(1);
assert.equal(end.influences.length, 3, 'two joints and their combination');
for (const weight of end.influences) assert(Math.abs(weight - 1) < 1e-5, `full at the end, not ${weight}`);
const distance = greatest(end.positions, read(path('posed.obj')));
assert(distance < 1e-5 * size, `the player shows Knead's pose, up to ${distance}`);

const before = volume(rest.positions);
for (const time of [0.25, 0.5, 0.75, 1]) {
  const corrected = volume(at(time).positions) / before - 1;
  const linear = volume(at(time, false).positions) / before - 1;
  console.log(
    `time ${time}: volume ${(100 * corrected).toFixed(3)}% in the player, ${(100 * linear).toFixed(3)}% without the shapes`,
  );
  assert(Math.abs(corrected) < Math.abs(linear) && Math.abs(corrected) < 0.01, `volume at ${time}`);
  assert(time < 1 || Math.abs(corrected) < 1e-4, 'volume at the end');
}
console.log(`three.js ${THREE.REVISION}: at the end ${distance.toExponential(1)} from Knead's pose`);

// Run by compare.py: plays the animation of a GLB file with three.js and writes the vertices of each frame as floats; the
// validator of Khronos finds no error.
//   node in_three.mjs FILE.glb FRAMES OUT
globalThis.self = globalThis;
globalThis.ProgressEvent = class {};
import fs from 'fs';
import validator from 'gltf-validator';
import * as THREE from 'three';
import { GLTFLoader } from 'three/examples/jsm/loaders/GLTFLoader.js';

const [file, frames, out] = process.argv.slice(2);
const bytes = fs.readFileSync(file);
const { issues } = await validator.validateBytes(new Uint8Array(bytes));
if (issues.numErrors + issues.numWarnings > 0) throw new Error(JSON.stringify(issues.messages.slice(0, 3)));
const gltf = await new Promise((resolve, reject) =>
  new GLTFLoader().parse(bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.length), '', resolve, reject));
const mixer = new THREE.AnimationMixer(gltf.scene);
const action = gltf.animations.length > 0 ? mixer.clipAction(gltf.animations[0]) : null;
action?.setLoop(THREE.LoopOnce);
if (action) action.clampWhenFinished = true;
action?.play();
let mesh;
gltf.scene.traverse((object) => { if (object.isMesh || object.isPoints) mesh = object; });
gltf.scene.updateMatrixWorld(true);
const shown = [];
for (let k = 0; k < frames; ++k) {
  mixer.setTime(k / 24);
  const count = mesh.geometry.attributes.position.count;
  const places = new Float32Array(3 * count);
  const p = new THREE.Vector3();
  for (let i = 0; i < count; ++i) mesh.getVertexPosition(i, p).applyMatrix4(mesh.matrixWorld).toArray(places, 3 * i);
  shown.push(Buffer.from(places.buffer));
}
fs.writeFileSync(out, Buffer.concat(shown));

// Run by compare.py: plays the animation of a GLB file with three.js and writes the vertices of each frame as floats; the
// validator of Khronos finds no error.
//   node in_three.mjs FILE.glb FRAMES OUT
globalThis.self = globalThis;
globalThis.ProgressEvent = class {};
import fs from 'fs';
import validator from 'gltf-validator';
import * as THREE from 'three';
import { GLTFLoader } from 'three/examples/jsm/loaders/GLTFLoader.js';
import { framesOf } from './frames.mjs';

const [file, frames, out] = process.argv.slice(2);
const bytes = fs.readFileSync(file);
const { issues } = await validator.validateBytes(new Uint8Array(bytes));
if (issues.numErrors + issues.numWarnings > 0) throw new Error(JSON.stringify(issues.messages.slice(0, 3)));
const gltf = await new Promise((resolve, reject) =>
  new GLTFLoader().parse(bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.length), '', resolve, reject));
const shown = framesOf(THREE, gltf, Number(frames));
fs.writeFileSync(out, Buffer.concat(shown.map((places) => Buffer.from(places.buffer))));

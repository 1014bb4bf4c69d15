// Run by compare.py: the same as in_three.mjs, in a page of Chromium; and each frame as the graphics driver draws it, with
// the weights at work, is compared with a picture of the places themselves.
//   node in_chromium.mjs FILE.glb FRAMES OUT
import fs from 'fs';
import http from 'http';
import path from 'path';
import { chromium } from 'playwright-core';

const [file, frames, out] = process.argv.slice(2);
const page_text = `<!doctype html><script type="importmap">{"imports": {"three": "/node_modules/three/build/three.module.js",
"three/": "/node_modules/three/"}}</script><script type="module">
import * as THREE from 'three';
import { GLTFLoader } from 'three/examples/jsm/loaders/GLTFLoader.js';
import { framesOf } from '/frames.mjs';
const renderer = new THREE.WebGLRenderer({ preserveDrawingBuffer: true });
renderer.setSize(256, 256);
const pixels = (scene, camera) => {
  renderer.render(scene, camera);
  const gl = renderer.getContext();
  const bytes = new Uint8Array(4 * 256 * 256);
  gl.readPixels(0, 0, 256, 256, gl.RGBA, gl.UNSIGNED_BYTE, bytes);
  return bytes;
};
// How many pixels show the shape in one picture and not in the other, and in both.
const compare = (a, b) => {
  let differ = 0, both = 0;
  for (let i = 0; i < a.length; i += 4) {
    const [here, there] = [a[i] > 0, b[i] > 0];
    differ += here !== there;
    both += here && there;
  }
  return { differ, both };
};
window.play = async (frames) => {
  const bytes = await (await fetch('/file.glb')).arrayBuffer();
  const gltf = await new GLTFLoader().parseAsync(bytes, '');
  const counts = [];
  const shown = framesOf(THREE, gltf, frames, (mesh, places) => {
    const box = new THREE.Box3().setFromArray(places);
    const sphere = box.getBoundingSphere(new THREE.Sphere());
    const r = sphere.radius;
    const camera = new THREE.OrthographicCamera(-r, r, r, -r, 0, 4 * r);
    camera.position.copy(sphere.center).add(new THREE.Vector3(0.6, 0.5, 0.8).normalize().multiplyScalar(2 * r));
    camera.lookAt(sphere.center);
    const still = new THREE.BufferGeometry();
    still.setAttribute('position', new THREE.BufferAttribute(places, 3));
    still.setIndex(mesh.geometry.index);
    const white = new THREE.MeshBasicMaterial({ side: THREE.DoubleSide });
    const scene = new THREE.Scene();
    scene.add(new THREE.Mesh(still, white));
    mesh.material = white;
    counts.push(compare(pixels(gltf.scene, camera), pixels(scene, camera)));
  });
  return { counts, shown: shown.map((places) => Array.from(places)) };
};
window.is_ready = true;
</script>`;
const served = { '.mjs': 'text/javascript', '.js': 'text/javascript', '.glb': 'model/gltf-binary' };
const server = http.createServer((request, response) => {
  const name = decodeURI(request.url);
  if (name === '/') return response.writeHead(200, { 'content-type': 'text/html' }).end(page_text);
  const from = name === '/file.glb' ? file : path.join(process.cwd(), path.normalize(name));
  if (!fs.existsSync(from)) return response.writeHead(404).end();
  response.writeHead(200, { 'content-type': served[path.extname(from)] ?? 'application/octet-stream' });
  response.end(fs.readFileSync(from));
});
await new Promise((resolve) => server.listen(0, '127.0.0.1', resolve));
const browser = await chromium.launch({
  executablePath: '/usr/bin/chromium',
  args: ['--no-sandbox', '--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader'],
});
try {
  const page = await browser.newPage();
  page.on('pageerror', (error) => { throw error; });
  await page.goto(`http://127.0.0.1:${server.address().port}/`);
  await page.waitForFunction(() => window.is_ready);
  const { counts, shown } = await page.evaluate((n) => window.play(n), Number(frames));
  for (const [k, { differ, both }] of counts.entries()) {
    if (both < 1000 || differ > 0.002 * both) throw new Error(`frame ${k}: ${differ} of ${both} pixels differ`);
  }
  fs.writeFileSync(out, Buffer.concat(shown.map((places) => Buffer.from(new Float32Array(places).buffer))));
} finally {
  await browser.close();
  server.close();
}

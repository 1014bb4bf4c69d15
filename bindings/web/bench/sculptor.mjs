// Prints start, steps of a drag and memory of Studio's page beside those of the sculptor that three.js ships, in one run,
// with the same shape and the same movements of the pointer: node bench/sculptor.mjs SHAPE.ply [RUNS]. Studio has its tool
// Move, three.js its drag with a brush about as large.
import { copyFileSync, mkdtempSync, readFileSync, rmSync, symlinkSync, writeFileSync } from 'node:fs';
import os from 'node:os';
import path from 'node:path';
import { serve } from '../serve.mjs';
import { startBrowser } from '../tests/browser.mjs';
import { built } from '../tests/support.mjs';

const [shape, runs = '3'] = process.argv.slice(2);
const size = { width: 1200, height: 800 };

const sculptorPage = `<!doctype html><title>Sculptor</title><style>body { margin: 0 }</style>
<script type="importmap">{"imports": {"three": "./three/build/three.module.js", "three/addons/": "./three/examples/jsm/"}}</script>
<script type="module">
import * as THREE from 'three';
import { PLYLoader } from 'three/addons/loaders/PLYLoader.js';
import { Sculptor } from 'three/addons/misc/Sculptor.js';
const renderer = new THREE.WebGLRenderer({ antialias: true });
renderer.setSize(innerWidth, innerHeight);
document.body.append(renderer.domElement);
const scene = new THREE.Scene();
const camera = new THREE.PerspectiveCamera(35, innerWidth / innerHeight, 0.01, 100);
scene.add(new THREE.HemisphereLight(0xffffff, 0x444444, 3));
renderer.setAnimationLoop(() => renderer.render(scene, camera));
window.bring = async () => {
  const geometry = await new PLYLoader().loadAsync('./shape.ply');
  geometry.computeBoundingSphere();
  const { center, radius } = geometry.boundingSphere;
  camera.position.copy(center).add(new THREE.Vector3(0, 0, 3.5 * radius));
  camera.lookAt(center);
  const mesh = new THREE.Mesh(geometry, new THREE.MeshStandardMaterial());
  scene.add(mesh);
  const sculptor = new Sculptor(mesh, camera).setTool('drag').setSize(70);
  sculptor.connect(renderer.domElement);
  window.changes = 0;
  sculptor.addEventListener('change', () => ++window.changes);
};
window.hasStarted = true;
</script>`;

function sculptorFolder() {
  const folder = mkdtempSync(path.join(os.tmpdir(), 'knead-web-'));
  symlinkSync(path.join(built, 'node_modules/three'), path.join(folder, 'three'));
  copyFileSync(shape, path.join(folder, 'shape.ply'));
  writeFileSync(path.join(folder, 'index.html'), sculptorPage);
  return folder;
}

const folder = sculptorFolder();
const pages = {
  'Knead Studio': {
    root: path.join(built, 'site'),
    hasStarted: () => window.kneadStudio !== undefined,
    bring: async (tab) => {
      await tab.setInputFiles('#files', shape);
      await tab.waitForFunction((name) => document.title.includes(name), path.basename(shape));
    },
    hasWorked: (tab) => tab.evaluate(() => document.title.includes('*')),
  },
  three: {
    root: folder,
    hasStarted: () => window.hasStarted,
    bring: (tab) => tab.evaluate(() => window.bring()),
    hasWorked: (tab) => tab.evaluate(() => window.changes > 0),
  },
};

// Until the picture after next: the next one may have begun before the pointer moved.
const frame = (tab) =>
  tab.evaluate(async () => {
    for (let i = 0; i < 2; ++i) await new Promise((resolve) => requestAnimationFrame(resolve));
  });

async function measure(name, { root, hasStarted, bring, hasWorked }) {
  const server = await serve(root);
  const browser = await startBrowser();
  const tab = await browser.newPage({ viewport: size });
  const began = performance.now();
  await tab.goto(`http://127.0.0.1:${server.address().port}/`);
  await tab.waitForFunction(hasStarted);
  await frame(tab);
  const start = performance.now() - began;
  await bring(tab);
  for (let i = 0; i < 30; ++i) await frame(tab);
  await tab.mouse.move(540, 400);
  await tab.mouse.down();
  const steps = [];
  for (let i = 1; i <= 30; ++i) {
    const moved = performance.now();
    await tab.mouse.move(540 + 4 * i, 400 - 2 * i);
    await frame(tab);
    steps.push(performance.now() - moved);
  }
  await tab.mouse.up();
  await frame(tab);
  if (!(await hasWorked(tab))) throw new Error(`${name}: the drag moved nothing`);
  if (process.env.KNEAD_WEB_PICTURES) {
    await tab.screenshot({ path: path.join(process.env.KNEAD_WEB_PICTURES, `beside_${name.replace(' ', '_')}.png`) });
  }
  const { bytes } = await tab.evaluate(() => performance.measureUserAgentSpecificMemory());
  await browser.close();
  server.close();
  steps.sort((a, b) => a - b);
  return { start, median: steps[15], most: steps[29], bytes };
}

console.log(`${path.basename(shape)}, ${(readFileSync(shape).length / 1e6).toFixed(1)} MB`);
for (let run = 0; run < Number(runs); ++run) {
  for (const [name, page] of Object.entries(pages)) {
    const { start, median, most, bytes } = await measure(name, page);
    console.log(`${name.padEnd(13)} start ${start.toFixed(0)} ms; a step of a drag and two pictures ${median.toFixed(0)} ms (median), ` +
      `${most.toFixed(0)} at most; memory of the page ${(bytes / 1e6).toFixed(0)} MB`);
  }
}
rmSync(folder, { recursive: true });

// The module and its example in node and in Chromium: the same bits.
import assert from 'node:assert/strict';
import { cpSync, mkdirSync, writeFileSync } from 'node:fs';
import path from 'node:path';
import { it } from 'node:test';
import { bentTube } from 'knead/example.mjs';
import { serve } from '../serve.mjs';
import { skip, startBrowser } from './browser.mjs';
import { built, scratch } from './support.mjs';

const page = `<!doctype html>
<script type="importmap">{"imports": {"three": "/three.module.js", "knead": "/npm/index.js"}}</script>
<script type="module">
  import * as THREE from 'three';
  import { bentTube } from '/npm/example.mjs';
  const { mesh, report } = await bentTube();
  const renderer = new THREE.WebGLRenderer({ antialias: true });
  renderer.setSize(400, 400);
  document.body.append(renderer.domElement);
  const scene = new THREE.Scene();
  scene.add(mesh, new THREE.HemisphereLight(0xffffff, 0x404040, 3));
  const camera = new THREE.PerspectiveCamera(40, 1, 0.1, 10);
  camera.position.set(0, 0, 4);
  renderer.render(scene, camera);
  window.result = { positions: Array.from(mesh.geometry.attributes.position.array), report };
</script>`;

it('the example bends a tube of three.js, in node and in Chromium alike', { skip }, async (test) => {
  const { mesh, report } = await bentTube();
  const { position } = mesh.geometry.attributes;
  assert.ok(report.moved_vertices > 1000 && report.moved_vertices <= position.count);
  assert.ok(Math.abs(report.volume_error ?? 0) < 1e-3);
  const folder = scratch(test);
  cpSync(path.join(built, 'npm'), path.join(folder, 'npm'), { recursive: true });
  for (const name of ['three.module.js', 'three.core.js']) {
    cpSync(path.join(built, 'node_modules/three/build', name), path.join(folder, name));
  }
  writeFileSync(path.join(folder, 'index.html'), page);
  const server = await serve(folder);
  test.after(() => server.close());
  const browser = await startBrowser();
  test.after(() => browser.close());
  const tab = await browser.newPage();
  const errors = [];
  tab.on('pageerror', (error) => errors.push(error.message));
  await tab.goto(`http://127.0.0.1:${server.address().port}/`);
  await tab.waitForFunction(() => window.result).catch((error) => assert.fail(`${errors.join('; ')} ${error.message}`));
  const shown = await tab.evaluate(() => window.result);
  assert.deepEqual(new Float32Array(shown.positions), position.array);
  assert.equal(shown.report.moved_vertices, report.moved_vertices);
  if (process.env.KNEAD_WEB_PICTURES) {
    mkdirSync(process.env.KNEAD_WEB_PICTURES, { recursive: true });
    await tab.screenshot({ path: path.join(process.env.KNEAD_WEB_PICTURES, 'example.png'), clip: { x: 0, y: 0, width: 416, height: 416 } });
  }
});

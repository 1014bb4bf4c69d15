// The module and its example in node and in Chromium: the same bits.
import assert from 'node:assert/strict';
import { mkdirSync } from 'node:fs';
import path from 'node:path';
import { it } from 'node:test';
import { bentTube } from 'knead/example.mjs';
import { resultOf, show, skip } from './browser.mjs';

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

const workerPage = `<!doctype html>
<script type="module">
  import { startWorker } from '/npm/client.js';
  const worker = startWorker();
  const sides = 400;
  const positions = Float32Array.from({ length: 3 * sides * sides }, (_, i) => 2 * Math.sin(i * 0.7));
  const stroke = '{"tool": "bend", "center": [0, 0, 0], "axis": [0, 0, 1], "normal": [0, 1, 0], "width": 2.5, "angle_deg": 60}';
  const sessionOf = (strokes) => '{"knead": 1}' + String.fromCharCode(10) + (stroke + String.fromCharCode(10)).repeat(strokes);
  const once = await worker.deform({ positions }, sessionOf(1));
  const controller = new AbortController();
  let fractions = 0;
  let cancelled;
  const long = worker.deform({ positions }, sessionOf(200), {
    signal: controller.signal,
    onProgress: () => {
      fractions += 1;
      if (fractions !== 2) return;
      cancelled = performance.now();
      controller.abort();
    },
  });
  const reason = await long.catch((error) => error.name);
  const seconds = (performance.now() - cancelled) / 1000;
  const again = await worker.deform({ positions }, sessionOf(1));
  const wrong = await worker.deform({ positions }, 'nonsense').catch((error) => error.name);
  const same = again.positions.every((x, i) => x === once.positions[i]);
  const moved = again.positions.some((x, i) => x !== positions[i]);
  window.result = { fractions, reason, seconds, same, moved, wrong };
</script>`;

it('a worker tells its progress, is cancelled at once, and works again', { skip }, async (test) => {
  const tab = await show(test, workerPage);
  const result = await resultOf(tab);
  assert.ok(result.seconds < 0.5, `${result.seconds} s`);
  assert.deepEqual({ ...result, seconds: 0 },
    { fractions: 2, reason: 'AbortError', seconds: 0, same: true, moved: true, wrong: 'KneadError' });
});

it('the example bends a tube of three.js, in node and in Chromium alike', { skip }, async (test) => {
  const { mesh, report } = await bentTube();
  const { position } = mesh.geometry.attributes;
  assert.ok(report.moved_vertices > 1000 && report.moved_vertices <= position.count);
  assert.ok(Math.abs(report.volume_error ?? 0) < 1e-3);
  const tab = await show(test, page);
  const shown = await resultOf(tab);
  assert.deepEqual(new Float32Array(shown.positions), position.array);
  assert.equal(shown.report.moved_vertices, report.moved_vertices);
  if (process.env.KNEAD_WEB_PICTURES) {
    mkdirSync(process.env.KNEAD_WEB_PICTURES, { recursive: true });
    await tab.screenshot({ path: path.join(process.env.KNEAD_WEB_PICTURES, 'example.png'), clip: { x: 0, y: 0, width: 416, height: 416 } });
  }
});

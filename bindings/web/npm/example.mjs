// Bends and twists a tube of three.js. `node example.mjs` prints what came of it; a page shows `bentTube()` in its scene.
import * as THREE from 'three';
import { deform } from 'knead';

const session = `{"knead": 1}
{"tool": "bend", "center": [0, -0.3, 0], "axis": [0, 0, 1], "normal": [0, -1, 0], "width": 1.2, "angle_deg": 70}
{"tool": "implicit", "path": [[0, -1, 0], [0, -1.4, 0]], "inner": 0.1, "outer": 0.6}
`;

// Deforms a geometry in place and returns the report.
export async function knead(geometry, text) {
  const mesh = { positions: geometry.attributes.position.array, indices: geometry.index?.array };
  const { positions, report } = await deform(mesh, text, { report: true });
  geometry.attributes.position.array.set(positions);
  geometry.attributes.position.needsUpdate = true;
  geometry.computeVertexNormals();
  return report;
}

export async function bentTube() {
  const geometry = new THREE.CylinderGeometry(0.2, 0.2, 2, 64, 128);
  const report = await knead(geometry, session);
  return { mesh: new THREE.Mesh(geometry, new THREE.MeshStandardMaterial({ color: 0xc07040 })), report };
}

if (globalThis.process?.argv?.[1]?.endsWith('example.mjs')) {
  const { report } = await bentTube();
  console.log(`${report.moved_vertices} of ${report.vertices} vertices moved`);
}

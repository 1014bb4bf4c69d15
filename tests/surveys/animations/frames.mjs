// The places of the vertices of a GLB file in each frame of its animation, as three.js plays it.

// look: called with the mesh and its places when a frame is played.
export function framesOf(THREE, gltf, frames, look = () => {}) {
  const mixer = new THREE.AnimationMixer(gltf.scene);
  const action = gltf.animations.length > 0 ? mixer.clipAction(gltf.animations[0]) : null;
  if (action) {
    action.setLoop(THREE.LoopOnce);
    action.clampWhenFinished = true;
    action.play();
  }
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
    look(mesh, places);
    shown.push(places);
  }
  return shown;
}

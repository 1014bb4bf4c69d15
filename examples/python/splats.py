#!/usr/bin/env python3
"""A made capture, bent: as it was, bent rightly, and with the centres moved alone. The pictures of docs/splats.md.

    knead make cylinder -n 20000 -o bar.ply
    PYTHONPATH=build/release/python python3 examples/python/splats.py bar.ply out

Writes capture.ply, bent.ply, centres_only.ply and bend.knead to `out`. Then
`knead render out/capture.ply out/bent.ply out/centres_only.ply --view 90,10 --size 1500x360 -o splats.jpg` draws them.
"""

import sys
from pathlib import Path

import numpy as np

import knead

COUNT = 15_000


def cover(shape):
    """Returns thin discs on the surface, with stripes and a colour that depends a little on the direction."""
    numbers = np.random.default_rng(1)
    corners = shape.vertices[shape.triangles]
    a, b = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    normals = np.cross(a, b)
    areas = np.linalg.norm(normals, axis=1) / 2
    chosen = numbers.choice(len(areas), COUNT, p=areas / areas.sum())
    u, v = numbers.random((2, COUNT, 1))
    u, v = np.where(u + v > 1, 1 - u, u), np.where(u + v > 1, 1 - v, v)
    means = corners[chosen, 0] + u * a[chosen] + v * b[chosen]
    n = normals[chosen] / (2 * areas[chosen, None])
    turns = np.stack([1 + n[:, 2], -n[:, 1], n[:, 0], 0 * u[:, 0]], axis=1) + [1e-9, 0, 0, 0]  # takes z to the normal
    size = np.sqrt(areas.sum() / COUNT)
    scales = np.tile(np.log([1.5 * size, 0.5 * size, 0.1 * size]), (COUNT, 1))
    harmonics = np.zeros((COUNT, 4, 3))
    harmonics[:, 0] = 1.3 * np.sin(25 * means)
    harmonics[:, 1:] = [0.2, 0.3, 0.1]
    arrays = means, scales, turns / np.linalg.norm(turns, axis=1)[:, None], harmonics, np.full(COUNT, 3.0)
    return knead.Splats(*(array.astype(np.float32) for array in arrays))


def main():
    mesh, out = knead.read(sys.argv[1]), Path(sys.argv[2])
    out.mkdir(exist_ok=True)
    capture = cover(mesh)
    session = knead.Session([knead.Bend(center=(0, 0, 0), axis=(1, 0, 0), normal=(0, 0, 1), width=3, angle_deg=110)])
    bent = knead.deform_mesh(capture, session)
    capture.write(out / "capture.ply")
    session.write(out / "bend.knead")
    bent.write(out / "bent.ply")
    means = knead.deform_mesh(capture, session, max_splats=0).means
    knead.Splats(means, capture.scales, capture.rotations, capture.harmonics, capture.opacities).write(out / "centres_only.ply")


if __name__ == "__main__":
    main()

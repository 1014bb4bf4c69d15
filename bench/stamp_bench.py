"""Stamps that stick and stamps that slip, on the same drags: prints a line for each. Run by hand:

    PYTHONPATH=build/release/python KNEAD=build/release/knead python3 bench/stamp_bench.py [--vertices 16000]

Lengths are relative to the unit sphere that is stamped. The ball has the radius 0.3, the letter Y the half extent 0.4.
Needs numpy.
"""

import argparse
import json
import math
import os
import pathlib
import subprocess
import tempfile
import time

import knead
import numpy as np

KNEAD = pathlib.Path(os.environ.get("KNEAD", "knead")).resolve()


def around(angle):
    return [1.2 * math.sin(angle), 0, 1.2 * math.cos(angle)]


SCENES = {
    "ball, pressed 0.1": ("ball", 0.3, [[0, 0, 1.32], [0, 0, 1.2]]),
    "ball, 2 radians round": ("ball", 0.3, [[0, 0, 1.32]] + [around(2 * i / 100) for i in range(101)]),
    "letter, pressed 0.2": ("letter-y", 0.4, [[0, 0, 1.3], [0, 0, 0.98]]),
    "letter, 0.3 aside": ("letter-y", 0.4, [[0, 0, 1.3], [0, 0, 0.98], [0.3, 0, 0.98]]),
}


def groove(places):
    """Mean and deviation of the ball's groove along the way, but for its two ends, at the vertices."""
    angle = np.arctan2(places[:, 0], places[:, 2])
    depths = []
    for at in np.arange(0.3, 1.75, 0.1):
        there = (np.abs(angle - at) < 0.03) & (np.abs(places[:, 1]) < 0.04)
        depths.append(1 - np.linalg.norm(places[there], axis=1).min())
    return np.mean(depths), np.std(depths)


def edge_stretch(before, after, faces):
    edges = np.vstack([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    lengths = [np.linalg.norm(places[edges[:, 0]] - places[edges[:, 1]], axis=1) for places in (before, after)]
    ratios = lengths[1] / lengths[0]
    return ratios.min(), ratios.max()


def measure(folder, name, contact):
    tool, size, path = SCENES[name]
    pose = (size * np.eye(3)).tolist()
    stroke = {"tool": "stamp", "mesh": f"{tool}.ply", "path": path, "pose": pose, "contact": contact}
    (folder / "s.knead").write_text('{"knead": 1}\n' + json.dumps(stroke) + "\n")
    words = [KNEAD, "deform", "sphere.ply", "s.knead", "-q", "--report", "-", "-o", "out.ply"]
    began = time.perf_counter()
    report = json.loads(subprocess.run(words, cwd=folder, check=True, capture_output=True, text=True).stdout)
    seconds = time.perf_counter() - began
    before, after = knead.read(folder / "sphere.ply"), knead.read(folder / "out.ply")
    crossings = len(knead.crossings(after.vertices, after.faces))
    least, greatest = edge_stretch(before.vertices, after.vertices, before.faces)
    line = (
        f"{name:22} {contact:5}: crossings {crossings:5}, volume {report['volume_error']:8.1e}, "
        f"edges {least:.2f}..{greatest:.2f}, penetration {report['penetration']:.4f}, {seconds:.1f} s"
    )
    if name.startswith("ball, 2") and contact == "slip":  # the other leaves none
        line += ", groove {:.4f}, deviation {:.4f}".format(*groove(after.vertices))
    print(line, flush=True)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--vertices", type=int, default=16000)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        for shape, words in {"sphere": ["-n", options.vertices], "ball": ["-n", 2562], "letter-y": []}.items():
            kind = "sphere" if shape == "ball" else shape
            subprocess.run([KNEAD, "make", kind, *map(str, words), "-q", "-o", folder / f"{shape}.ply"], check=True)
        for scene in SCENES:
            for contact in ("slip", "stick"):
                measure(folder, scene, contact)


if __name__ == "__main__":
    main()

#!/usr/bin/env python3
"""The mean of people, and what they look like along the first mode in which they differ.

    python3 -m venv bodies && bodies/bin/pip install anny
    bodies/bin/python bench/fit_bodies.py people --people 10
    PYTHONPATH=build/release/python python3 examples/python/population.py people out

The bodies are those of anny (shapes CC0). All have the same vertices, which the fits do not know; how far a fit
takes a vertex from where it belongs is printed. Each session in `out` is for person_0.
"""

import sys
from pathlib import Path

import numpy as np

import knead


def main():
    folder, out = map(Path, sys.argv[1:])
    out.mkdir(exist_ok=True)
    paths = sorted(folder.glob("*.obj"))
    shapes = [knead.read(path) for path in paths]
    faces = shapes[0].triangles
    people = knead.mean([(s.vertices, faces) for s in shapes])
    for path, shape, fit in zip(paths, shapes, people.fits):
        report = fit.report
        error = np.linalg.norm(fit.vertices - shape.vertices, axis=1) / np.linalg.norm(np.ptp(shape.vertices, axis=0))
        print(
            f"{path.stem}: volume {report['volume_difference']:+.1%}, after {report['volume_error']:+.1%}, det J "
            f"{report['det_least']:.2f} to {report['det_greatest']:.2f}, distance {report['distance_after']['mean']:.3%}, "
            f"vertices {error.mean():.2%}, {report['crossings_new']} new crossings {fit.problem}"
        )
    print(f"mean: {people.mean.report['crossings_new']} new crossings {people.mean.problem}")
    share = people.deviations**2 / (people.deviations**2).sum()
    print("modes:", ", ".join(f"{part:.0%}" for part in share))
    people.mean.session.write(out / "mean.knead")
    knead.write(out / "mean.ply", people.mean.vertices, faces)
    for weight in (-2, 2):
        along = people.along([weight])
        along.session.write(out / f"mode_{weight:+d}.knead")
        knead.write(out / f"mode_{weight:+d}.ply", along.vertices, faces)
        print(f"{weight:+d} standard deviations: {along.report['crossings_new']} new crossings {along.problem}")


if __name__ == "__main__":
    main()

"""Makes a body in several poses, or people of different build, one file each with the same vertices, for fit_bench.py.

    python3 -m venv bodies && bodies/bin/pip install anny
    bodies/bin/python bench/fit_bodies.py FOLDER
    PYTHONPATH=build/release/python python3 bench/fit_bench.py FOLDER --landmarks 0 20
    bodies/bin/python bench/fit_bodies.py FOLDER --people 10

The body and its rig are those of anny (code Apache-2.0, shapes CC0): https://github.com/naver/anny. The first start takes
minutes. Eyes, teeth and tongue are left out: a file holds the largest piece alone.
"""

import argparse
from pathlib import Path

import anny
import numpy as np
import torch

# What each pose turns: the bone, the axis of the turn in the bone's frame, degrees.
POSES = {
    "0_rest": [],
    "1_arm": [("upperarm01.L", (0, 0, 1), 45)],
    "2_elbows": [("lowerarm01.L", (1, 0, 0), 60), ("lowerarm01.R", (1, 0, 0), 60)],
    "3_walk": [
        ("upperleg01.L", (1, 0, 0), 35),
        ("upperleg01.R", (1, 0, 0), -25),
        ("lowerleg01.R", (1, 0, 0), 30),
        ("upperarm01.L", (1, 0, 0), 25),
    ],
}


def person(number):
    """What anny calls a phenotype: ten different ones, in no order."""
    # The fractional parts of multiples of roots: evenly spread.
    spread = lambda root: float(0.15 + 0.7 * ((number + 1) * np.sqrt(root) % 1))  # noqa: E731
    return {"gender": spread(2), "age": 0.55 + 0.35 * spread(3), "muscle": spread(5), "weight": spread(7), "height": spread(11)}


def turn(axis, degrees):
    """The 4 x 4 matrix of a rotation (Rodrigues' formula)."""
    x, y, z = axis
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]], float)
    angle = np.radians(degrees)
    matrix = np.eye(4)
    matrix[:3, :3] += np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross
    return torch.tensor(matrix[None], dtype=torch.float32)


def largest_piece(count, faces):
    """Which vertices belong to the piece with the most of them."""
    piece = np.arange(count)
    while True:
        least = piece.copy()
        np.minimum.at(least, faces.ravel(), np.repeat(piece[faces].min(axis=1), 3))
        if (least == piece).all():
            return piece == np.bincount(piece).argmax()
        piece = least[least]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--people", type=int, default=0, help="so many people in the same pose, in the place of poses")
    options = parser.parse_args()
    folder = options.folder
    folder.mkdir(parents=True, exist_ok=True)
    model = anny.create_fullbody_model()
    faces = np.asarray(model.get_triangular_faces())
    made = {name: ({bone: turn(axis, degrees) for bone, axis, degrees in turns}, None) for name, turns in POSES.items()}
    if options.people:
        made = {f"person_{i}": ({}, person(i)) for i in range(options.people)}
    for name, (parameters, phenotype) in made.items():
        vertices = model(pose_parameters=parameters or None, phenotype_kwargs=phenotype)["vertices"][0].detach().numpy()
        kept = largest_piece(len(vertices), faces)
        number = np.cumsum(kept)
        lines = ["v %.9g %.9g %.9g" % tuple(v) for v in vertices[kept]]
        lines += ["f %d %d %d" % tuple(number[f]) for f in faces[kept[faces].all(axis=1)]]
        (folder / f"{name}.obj").write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()

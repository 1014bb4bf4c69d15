"""Runs README's example of Python with the module that is installed, on a sphere, and compares with what must come."""

import sys

import knead
import numpy as np

n = 2000
i = np.arange(n) + 0.5
height, turn = 1 - 2 * i / n, np.pi * (1 + 5**0.5) * i
r = np.sqrt(1 - height**2)
with open("scan.ply", "w") as file:
    file.write(f"ply\nformat ascii 1.0\nelement vertex {n}\nproperty double x\nproperty double y\nproperty double z\nend_header\n")
    np.savetxt(file, np.column_stack([r * np.cos(turn), height, r * np.sin(turn)]), fmt="%.17g")

shape = knead.read("scan.ply")
before = np.array(shape.vertices)
pull = knead.Implicit(path=[[0, 1, 0], [0, 1.4, 0]], inner=0.1, outer=0.5)
shape.vertices = knead.deform(shape.vertices, pull)
shape.write("pulled.ply")

way = np.array(knead.read("pulled.ply").vertices) - before
top = before[:, 1] > 0.996  # within `inner`
assert np.abs(way[top] - [0, 0.4, 0]).max() < 1e-4, way[top]
assert (way[before[:, 1] < 0] == 0).all()
print("knead", knead.__version__, "in Python", sys.version.split()[0])

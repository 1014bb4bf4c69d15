"""Shapes as lists of numbers: from the dumps of the programs, and from OBJ by a reader of its own."""
import dataclasses

import numpy as np


@dataclasses.dataclass
class Shape:
    """`uv`, `color` and `normal`: one row for each corner, or for each vertex without faces; or none."""
    positions: np.ndarray
    sizes: np.ndarray
    corners: np.ndarray
    uv: np.ndarray
    color: np.ndarray
    normal: np.ndarray

    def items(self):
        """The vertex that each row of an attribute belongs to."""
        return self.corners if len(self.sizes) else np.arange(len(self.positions))


def read_dump(path):
    with open(path, "rb") as file:
        counts = np.frombuffer(file.read(48), "u8").astype(int)
        rows = []
        for count, kind, width in zip(counts, ("f8", "i4", "i4", "f8", "f8", "f8"), (3, 1, 1, 2, 4, 3)):
            data = np.frombuffer(file.read(int(count) * width * int(kind[1])), kind)
            rows.append(data.reshape(-1, width) if width > 1 else data.astype(int))
    return Shape(*rows)


def read_points(path):
    """XYZ: three further numbers are a colour if they are whole, else a normal."""
    rows = np.loadtxt(path, ndmin=2)
    none, further = np.zeros(0, int), rows[:, 3:6]
    color = np.zeros((0, 4))
    if further.size and (further == np.rint(further)).all() and further.max() > 1:
        color, further = np.hstack([further / 255, np.ones((len(rows), 1))]), further[:0]
    return Shape(rows[:, :3], none, none, np.zeros((0, 2)), color, further.reshape(-1, 3))


def index_of(word, count):
    return int(word) - 1 if int(word) > 0 else count + int(word)


def read_obj(path):
    """v with colours, vt, vn, f with any indices, lines joined by a backslash. The first colour decides for all."""
    v, vt, vn, sizes, corners = [], [], [], [], []
    with open(path, encoding="utf-8-sig", errors="replace", newline="") as file:
        text = file.read().replace("\\\r\n", " ").replace("\\\n", " ")
    for line in text.replace("\r", "\n").split("\n"):
        words = line.split("#")[0].split()
        if not words:
            continue
        if words[0] in ("v", "vt", "vn"):
            {"v": v, "vt": vt, "vn": vn}[words[0]].append([float(w) for w in words[1:]])
        elif words[0] == "f":
            sizes.append(len(words) - 1)
            for word in words[1:]:
                part = (word.split("/") + ["", ""])[:3]
                corners.append([index_of(p, len(n)) if p else -1 for p, n in zip(part, (v, vt, vn))])
    return shape_of_obj(v, vt, vn, np.array(sizes, int), np.array(corners, int).reshape(-1, 3))


def shape_of_obj(v, vt, vn, sizes, corners):
    positions = np.array([row[:3] for row in v], float).reshape(-1, 3)
    items = corners[:, 0] if len(sizes) else np.arange(len(v))

    def by_corner(rows, column, width):
        table = np.array([(row + [0.0])[:width] for row in rows], float).reshape(-1, width)
        if not len(table) or (len(sizes) and (corners[:, column] < 0).all()):
            return np.zeros((0, width))
        at = corners[:, column] if len(sizes) else np.arange(len(table))
        return np.where(at[:, None] < 0, np.nan, table[at])

    color = np.array([row[3:6] + [1.0] for row in v if len(row) >= 6], float).reshape(-1, 4)
    color = color[items] if len(color) == len(v) else np.zeros((0, 4))
    return Shape(positions, sizes, corners[:, 0], by_corner(vt, 1, 2), color, by_corner(vn, 2, 3))

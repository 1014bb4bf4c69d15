"""Small readers of OBJ, PLY, OFF, STL, GLB and XYZ for the checks in this folder. They share no code with Knead.

Each returns a File: the numbers that a deformation may change, where they stand in the bytes, and all other bytes. They
read sound files only, and only what the checks need: no hostile input, no sparse or quantized accessors.
"""
import json
import re
import struct
from dataclasses import dataclass, field

import numpy as np


@dataclass
class File:
    data: bytes
    text: bool
    spans: dict = field(default_factory=dict)  # "position", "normal": (rows, 3, 2) first and last byte of each number
    values: dict = field(default_factory=dict)  # the same names: (rows, 3) float64
    single: dict = field(default_factory=dict)  # whether they are floats rather than doubles
    free: list = field(default_factory=list)  # further spans that may change
    gone: list = field(default_factory=list)  # spans that may come and go
    corners: list = field(default_factory=list)  # faces as lists of rows of "position"
    normal_of: list = field(default_factory=list)  # (row of "position", row of "normal") that belong together
    points: bool = False  # has no faces
    world: np.ndarray = None  # positions in world coordinates; None: as they are
    world_normals: np.ndarray = None

    def positions(self):
        return self.values["position"] if self.world is None else self.world

    def normals(self):
        return self.values.get("normal") if self.world_normals is None else self.world_normals

    def skeleton(self):
        """The bytes with every number that may change taken out."""
        cut = list(self.free)
        for spans in self.spans.values():
            cut += [tuple(s) for s in np.asarray(spans).reshape(-1, 2).tolist()]
        result, at = b"", 0
        for begin, end, mark in sorted({(*s, b"\0|") for s in cut} | {(*s, b"") for s in self.gone}):
            result += self.data[at:begin] + mark
            at = end
        return result + self.data[at:]


def read(path, kind=None):
    data = open(path, "rb").read()
    kind = kind or path.rsplit(".", 1)[1].lower()
    return {"obj": read_obj, "ply": read_ply, "off": read_off, "stl": read_stl, "glb": read_glb, "xyz": read_xyz}[kind](data)


def put(file, name, words, single=False):
    """Rows of three regular-expression matches: the numbers and their places."""
    file.spans[name] = np.array([[m.span() for m in row] for row in words], dtype=np.int64).reshape(-1, 3, 2)
    values = np.array([[float(m.group()) for m in row] for row in words]).reshape(-1, 3)
    file.values[name] = values.astype(np.float32).astype(float) if single else values
    file.single[name] = single


def lines_of(data, begin=0):
    for m in re.compile(rb"[^\r\n]+").finditer(data, begin):
        words = list(re.compile(rb"[^ \t\v\f]+").finditer(data, *m.span()))
        if words:
            yield words


def read_obj(data):
    """Normals are those of the corners: lines vn may be added, and corners may refer to others."""
    file, vertices, lines, used = File(data, True), [], [], []
    for words in lines_of(data):
        key = words[0].group()
        if key == b"v":
            vertices.append(words[1:4])
        elif key == b"vn":
            lines.append([float(w.group()) for w in words[1:4]])
            file.gone.append((words[0].start(), re.compile(rb"[^\r\n]*(\r\n|\n|\r)?").match(data, words[0].start()).end()))
        elif key == b"f":
            corner = []
            for w in words[1:]:
                part = w.group().split(b"/")
                index = [int(p) if p else 0 for p in part] + [0, 0]
                given = [len(vertices), 0, len(lines)]
                v, _, n = [index[i] - 1 if index[i] > 0 else given[i] + index[i] for i in range(3)]
                corner.append(v)
                if index[2] != 0:
                    file.normal_of.append((v, len(used)))
                    used.append(n)
                    file.free.append((w.end() - len(part[2]), w.end()))
            file.corners.append(corner)
    put(file, "position", vertices)
    if lines:
        file.world_normals = np.array(lines).reshape(-1, 3)[used]
    return file


PLY_TYPES = {"char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4", "float": "f4",
             "double": "f8", "int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2", "int32": "i4", "uint32": "u4",
             "float32": "f4", "float64": "f8"}


def read_ply(data):
    end = re.search(rb"(\r?\n)end_header[^\n]*\n", data).end()
    elements, order = [], None
    for line in data[:end].decode("latin-1").split("\n"):
        w = line.split()
        if w[:1] == ["format"]:
            order = {"ascii": None, "binary_little_endian": "<", "binary_big_endian": ">"}[w[1]]
        elif w[:1] == ["element"]:
            elements.append((w[1], int(w[2]), []))
        elif w[:1] == ["property"]:
            elements[-1][2].append((w[-1], PLY_TYPES[w[-2]], PLY_TYPES[w[2]] if w[1] == "list" else None))
    file = File(data, order is None)
    words = re.compile(rb"\S+").finditer(data, end) if file.text else None
    at, found = end, {}
    for name, count, properties in elements:
        for _ in range(count):
            for prop, kind, list_kind in properties:
                n = 1
                if list_kind and file.text:
                    n = int(next(words).group())
                elif list_kind:
                    n = int(np.frombuffer(data, order + list_kind, 1, at)[0])
                    at += np.dtype(list_kind).itemsize
                size = np.dtype(kind).itemsize
                items = [next(words) for _ in range(n)] if file.text else None
                if not file.text:
                    if list_kind is None and name == "vertex":
                        found.setdefault(prop, []).append((at, at + size))
                        found.setdefault(prop + "=", []).append(float(np.frombuffer(data, order + kind, 1, at)[0]))
                    elif list_kind and name != "vertex":
                        found.setdefault("faces " + prop, []).append(np.frombuffer(data, order + kind, n, at).tolist())
                    at += n * size
                elif list_kind is None and name == "vertex":
                    found.setdefault(prop, []).append(items[0].span())
                    found.setdefault(prop + "=", []).append(float(items[0].group()))
                elif list_kind and name != "vertex":
                    found.setdefault("faces " + prop, []).append([float(i.group()) for i in items])
    kinds = {p: k for name, _, ps in elements if name == "vertex" for p, k, _ in ps}
    for name, axes in (("position", "x y z".split()), ("normal", "nx ny nz".split())):
        if axes[0] not in found:
            continue
        file.spans[name] = np.stack([np.array(found[a]) for a in axes], 1)
        values = np.stack([np.array(found[a + "="]) for a in axes], 1)
        file.single[name] = kinds[axes[0]] == "f4"
        file.values[name] = values.astype(np.float32).astype(float) if file.single[name] else values
    for key in ("faces vertex_indices", "faces vertex_index"):
        if any(e[0] == "face" for e in elements):
            file.corners += [[int(i) for i in f] for f in found.get(key, [])]
    file.points = not any(name in ("face", "tristrips") and count > 0 for name, count, _ in elements)
    if "normal" in file.values:
        file.normal_of = [(i, i) for i in range(len(file.values["normal"]))]
    return file


def read_off(data):
    word = data.split(None, 1)[0]
    if data.split(b"\n", 1)[0].strip().endswith(b"BINARY"):
        start = data.index(b"\n") + 1
        order = "<" if struct.unpack_from("<i", data, start)[0] < 1 << 24 else ">"
        nv, nf, _ = struct.unpack_from(order + "3i", data, start)
        width = 6 if b"N" in word else 3
        at = start + 12 + np.arange(nv)[:, None] * 4 * width + np.arange(3) * 4
        file = File(data, False)
        for k, name in enumerate(["position", "normal"][:width // 3]):
            file.spans[name] = np.stack([at + 12 * k, at + 12 * k + 4], 2)
            rows = np.frombuffer(data, order + "f4", nv * width, start + 12).reshape(nv, width)
            file.values[name], file.single[name] = rows[:, 3 * k:3 * k + 3].astype(float), True
        file.normal_of = [(i, i) for i in range(nv)]
        return file
    rows = [w for w in lines_of(re.sub(rb"#[^\r\n]*", lambda m: b" " * len(m.group()), data))]
    file = File(data, True)
    nv, nf = (int(w.group()) for w in rows[1][:2])
    put(file, "position", [w[:3] for w in rows[2:2 + nv]])
    if b"N" in word:
        put(file, "normal", [w[3:6] for w in rows[2:2 + nv]])
        file.normal_of = [(i, i) for i in range(nv)]
    file.corners = [[int(i.group()) for i in w[1:1 + int(w[0].group())]] for w in rows[2 + nv:2 + nv + nf]]
    return file


def read_stl(data):
    if len(data) >= 84 and len(data) >= 84 + 50 * struct.unpack_from("<I", data, 80)[0]:
        n = struct.unpack_from("<I", data, 80)[0]
        at = 84 + 50 * np.arange(n)[:, None] + 4 * np.arange(12)
        values = np.stack([np.frombuffer(data, "<f4", 12, 84 + 50 * t) for t in range(n)]).astype(float)
        file = File(data, False)
        spans = np.stack([at, at + 4], 2)
        file.spans = {"normal": spans[:, :3], "position": spans[:, 3:].reshape(-1, 3, 2)}
        file.values = {"normal": values[:, :3], "position": values[:, 3:].reshape(-1, 3)}
        file.single = {"normal": True, "position": True}
    else:
        file, normals, points = File(data, True), [], []
        for words in lines_of(data):
            if words[0].group().lower() == b"facet":
                normals.append(words[2:5])
            elif words[0].group().lower() == b"vertex":
                points.append(words[1:4])
        put(file, "normal", normals)
        put(file, "position", points)
    file.corners = [[3 * t, 3 * t + 1, 3 * t + 2] for t in range(len(file.values["position"]) // 3)]
    return file


def read_xyz(data):
    file = File(data, True, points=True)
    rows = [w for w in lines_of(data) if not w[0].group().startswith(b"#") and len(w) >= 3]
    put(file, "position", [w[:3] for w in rows])
    if len(rows[0]) == 6:
        put(file, "normal", [w[3:6] for w in rows])
        file.normal_of = [(i, i) for i in range(len(rows))]
    return file


def node_matrix(node):
    if "matrix" in node:
        return np.array(node["matrix"], float).reshape(4, 4).T
    x, y, z, w = node.get("rotation", [0, 0, 0, 1])
    turn = np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                     [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                     [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])
    m = np.eye(4)
    m[:3, :3] = turn * np.array(node.get("scale", [1, 1, 1]), float)
    m[:3, 3] = node.get("translation", [0, 0, 0])
    return m


def glb_json(data):
    size = struct.unpack_from("<I", data, 12)[0]
    return json.loads(data[20:20 + size]), 20 + size


def read_glb(data):
    """Float POSITION and NORMAL accessors, each placed by one node; TANGENT and the JSON may change."""
    document, end = glb_json(data)
    start = end + 8
    file = File(data, False, free=[(8, 16), (20, end)])
    rows = {"POSITION": [], "NORMAL": [], "TANGENT": []}
    world, world_normals, first, seen = [], [], 0, set()
    pending = [(n, np.eye(4)) for n in reversed(document["scenes"][document.get("scene", 0)]["nodes"])]
    while pending:
        index, parent = pending.pop()
        node = document["nodes"][index]
        m = parent @ node_matrix(node)
        pending += [(c, m) for c in reversed(node.get("children", []))]
        for primitive in document["meshes"][node["mesh"]]["primitives"] if "mesh" in node else []:
            if primitive["attributes"]["POSITION"] in seen:
                continue
            seen.add(primitive["attributes"]["POSITION"])
            for key, n in (("POSITION", 3), ("NORMAL", 3), ("TANGENT", 4)):
                if key not in primitive["attributes"]:
                    continue
                a = document["accessors"][primitive["attributes"][key]]
                view = document["bufferViews"][a["bufferView"]]
                at = start + view.get("byteOffset", 0) + a.get("byteOffset", 0)
                places = at + np.arange(a["count"])[:, None] * view.get("byteStride", 4 * n) + 4 * np.arange(n)
                values = np.array([np.frombuffer(data, "<f4", n, p[0]) for p in places]).astype(float)
                rows[key].append((np.stack([places, places + 4], 2), values))
                if key == "POSITION":
                    world.append(values @ m[:3, :3].T + m[:3, 3])
                    file.normal_of += [(first + i, first + i) for i in range(a["count"])]
                    first += a["count"]
                elif key == "NORMAL":
                    turned = values @ np.linalg.inv(m[:3, :3])
                    world_normals.append(turned / np.linalg.norm(turned, axis=1, keepdims=True))
    for key, name in (("POSITION", "position"), ("NORMAL", "normal")):
        if rows[key]:
            file.spans[name] = np.concatenate([r[0] for r in rows[key]])
            file.values[name], file.single[name] = np.concatenate([r[1] for r in rows[key]]), True
    file.free += [tuple(s) for r in rows["TANGENT"] for s in r[0].reshape(-1, 2).tolist()]
    file.world = np.concatenate(world)
    file.world_normals = np.concatenate(world_normals) if world_normals else None
    return file


def write_points(path, points):
    """A PLY file of points as doubles, binary little endian."""
    head = f"ply\nformat binary_little_endian 1.0\nelement vertex {len(points)}\n"
    head += "property double x\nproperty double y\nproperty double z\nend_header\n"
    open(path, "wb").write(head.encode() + np.ascontiguousarray(points, "<f8").tobytes())

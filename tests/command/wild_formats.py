"""Odd files of every format as other programs write them, and readers of their own. For wild_files.py."""
import base64
import itertools
import json
import os
import random
import re
import struct

SEED = 18
NAN = float("nan")


class Wild:
    """A file: its vertices in file order (None: not finite), its triangles, and whether assimp reads it."""

    def __init__(self, name, extension, data, points, faces, assimp=False, refused=None, beside=None, tolerance=1e-5):
        self.name, self.extension, self.data = name, extension, data
        self.points, self.faces, self.assimp = points, faces, assimp
        self.refused, self.beside, self.tolerance = refused, beside or {}, tolerance

    @property
    def file(self):
        return f"{self.name}.{self.extension}"


def cube(random):
    """The corners of a cube in random order, its triangles."""
    corners = list(itertools.product((0.0, 1.0), repeat=3))
    order = list(range(8))
    random.shuffle(order)
    place = {old: new for new, old in enumerate(order)}
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    faces = [[place[a], place[b], place[c]] for q in quads for a, b, c in ((q[0], q[1], q[2]), (q[0], q[2], q[3]))]
    return [corners[i] for i in order], faces


# --- PLY --------------------------------------------------------------------------------------------------------------

PLY_CODES = {"char": "b", "uchar": "B", "short": "h", "ushort": "H", "int": "i", "uint": "I", "float": "f",
             "double": "d", "int64": "q", "uint64": "Q"}


def ply(random, encoding, number="float", count="uchar", index="int", name="vertex_indices", bom=False, hashes=False,
        unused=0, surplus=False, extra=None, end="\n"):
    points, faces = cube(random)
    points = points + [None] * unused
    order = {"ascii": "<", "binary_little_endian": "<", "binary_big_endian": ">"}[encoding]
    head = ["ply", f"format {encoding} 1.0", "comment made by a test", f"element vertex {len(points)}"]
    head += [f"property {number} {c}" for c in "xyz"] + ([f"property {extra} stamp"] if extra else [])
    head += [f"element face {len(faces)}", f"property list {count} {index} {name}", "end_header"]
    if hashes:
        head[2:2] = ["# a line", "#"]
    data = (end.join(head) + end).encode()
    rows = [(p or (NAN, 1.5, NAN)) for p in points]
    if encoding == "ascii":
        tail = [" 7 255" if surplus and random.random() < 0.5 else "" for _ in rows + faces]
        lines = [" ".join("%g" % x for x in row) + (" %d" % i if extra else "") + tail[i] for i, row in enumerate(rows)]
        lines += [" ".join(map(str, [3] + f)) + tail[len(rows) + i] for i, f in enumerate(faces)]
        data += (end.join(lines) + end).encode()
    else:
        for i, row in enumerate(rows):
            data += struct.pack(order + "3" + PLY_CODES[number], *row)
            data += struct.pack(order + PLY_CODES[extra], i) if extra else b""
        for f in faces:
            data += struct.pack(order + PLY_CODES[count], 3) + struct.pack(order + "3" + PLY_CODES[index], *f)
    return (b"\xef\xbb\xbf" if bom else b"") + data, points, faces


def ply_files(random):
    encodings = ("ascii", "binary_little_endian", "binary_big_endian")
    for encoding, number, name in itertools.product(
            encodings, ("float", "double"), ("vertex_indices", "vertex_index", "vertex_indexes", "indices")):
        yield f"ply-{encoding}-{number}-{name}", ply(random, encoding, number, name=name), name in ("vertex_indices", "vertex_index")
    for encoding, (count, index) in itertools.product(
            encodings, (("uint64", "int64"), ("uchar", "uint64"), ("uchar", "float"), ("int", "double"),
                        ("ushort", "ushort"), ("char", "uchar"))):
        yield f"ply-{encoding}-{count}-{index}", ply(random, encoding, count=count, index=index), False
    for encoding, extra in itertools.product(encodings, ("int64", "uint64", "double")):
        yield f"ply-{encoding}-with-{extra}", ply(random, encoding, extra=extra), False
    for encoding, bom, hashes, unused, end in itertools.product(
            encodings, (False, True), (False, True), (0, 2), ("\n", "\r\n")):
        if bom or hashes or unused:
            what = ("-bom" * bom + "-hashes" * hashes + "-unused" * bool(unused)) + ("-crlf" if end != "\n" else "")
            yield f"ply-{encoding}{what}", ply(random, encoding, bom=bom, hashes=hashes, unused=unused, end=end), False
    for extra, unused, end in itertools.product((None, "int64"), (0, 1), ("\n", "\r\n", "\r")):
        what = f"{extra or 'plain'}-{unused}-{len(end)}{'r' in repr(end)}"
        yield f"ply-surplus-{what}", ply(random, "ascii", extra=extra, unused=unused, surplus=True, end=end), False


def read_ply(data):
    data = data[3:] if data[:3] == b"\xef\xbb\xbf" else data
    end = re.search(rb"end_header(\r\n|\n|\r)", data)
    words = [line.split() for line in re.split(r"\r\n|\n|\r", data[:end.start()].decode())]
    encoding = next(w[1] for w in words if w[:1] == ["format"])
    count = next(int(w[2]) for w in words if w[:2] == ["element", "vertex"])
    types = [w[1] for w in words if w[:1] == ["property"] and w[1] != "list"]
    if encoding == "ascii":
        rows = [line.split() for line in re.split(rb"\r\n|\n|\r", data[end.end():])]
        return [tuple(map(float, row[:3])) for row in rows[:count]]
    row = struct.Struct((">" if "big" in encoding else "<") + "".join(PLY_CODES[t] for t in types))
    return [row.unpack_from(data, end.end() + i * row.size)[:3] for i in range(count)]


# --- OBJ --------------------------------------------------------------------------------------------------------------

def obj_files(random):
    for corner, zeros, unused, end, negative in itertools.product(
            ("{0}//{1}", "{0}/{1}", "{0}/{1}/{1}", "{0}"), (0, 1, 511), (0, 2), ("\n", "\r\n"), (False, True)):
        if corner == "{0}" and not zeros and not unused:
            continue
        points, faces = cube(random)
        points += [None] * unused
        lines = ["# made by a test", "o cube"]
        lines += ["v " + " ".join("%g" % x for x in p or (NAN, NAN, NAN)) for p in points]
        for i, f in enumerate(faces):
            numbers = [(v - len(points) if negative else v + 1) for v in f]
            lines.append("f " + " ".join(corner.format(n, i % 3 + 1) for n in numbers))
        name = f"obj-{corner.format('v', 'n').replace('/', '_')}-{zeros}-{unused}-{len(end)}-{'minus' * negative}"
        yield name, ((end.join(lines) + end).encode() + b"\0" * zeros, points, faces), False


def read_obj(data):
    lines = re.split(rb"\r\n|\n|\r", data.rstrip(b"\0"))
    return [tuple(map(float, w[1:4])) for w in map(bytes.split, lines) if w[:1] == [b"v"]]


# --- STL --------------------------------------------------------------------------------------------------------------

def stl_text(points, faces, one_line, colors, split, endsolid, zeros, upper):
    gap = " " if one_line else "\n"
    loop, facet = ("end loop", "end facet") if split else ("endloop", "endfacet")
    parts = ["solid cube"] + (["color 1 0 0.5"] if colors else [])
    for i, f in enumerate(faces):
        parts += ["facet normal 0 0 1"] + (["color 0 1 0"] if colors and i % 3 == 0 else []) + ["outer loop"]
        parts += ["vertex " + " ".join("%g" % x for x in points[v]) for v in f] + [loop, facet]
    text = gap.join(parts + (["endsolid cube"] if endsolid else [])) + "\n"
    return (text.upper() if upper else text).encode() + b"\0" * zeros


def stl_files(random):
    flags = (False, True)
    for one_line, colors, split, endsolid, zeros, upper in itertools.product(flags, flags, flags, flags, (0, 80), flags):
        if colors and one_line:
            continue
        if endsolid and not (one_line or colors or split or zeros):
            continue
        points, faces = cube(random)
        data = stl_text(points, faces, one_line, colors, split, endsolid, zeros, upper)
        name = f"stl-{one_line:d}{colors:d}{split:d}{endsolid:d}{upper:d}-{zeros}"
        yield name, (data, [points[v] for f in faces for v in f], faces), False
    for declared, header in itertools.product((None, 0, 0xFFFFFFFF), (b"solid cube", b"made by a test", b"\0")):
        points, faces = cube(random)
        data = header.ljust(80, b"\0" if header == b"\0" else b" ")
        data += struct.pack("<I", len(faces) if declared is None else declared)
        for i, f in enumerate(faces):
            data += struct.pack("<12fH", 0, 0, 1, *(x for v in f for x in points[v]), i)
        yield (f"stl-binary-{declared}-{header[:1].hex()}", (data, [points[v] for f in faces for v in f], faces),
               declared is None)


def read_stl(data):
    if len(data) >= 84 and (len(data) - 84) % 50 == 0 and b"facet" not in data.lower()[80:400]:
        rows = [struct.unpack_from("<9f", data, 84 + 50 * i + 12) for i in range((len(data) - 84) // 50)]
        return [row[3 * k:3 * k + 3] for row in rows for k in range(3)]
    words = data.rstrip(b"\0").lower().split()
    return [tuple(map(float, words[i + 1:i + 4])) for i, word in enumerate(words) if word == b"vertex"]


# --- OFF --------------------------------------------------------------------------------------------------------------

def off_files(random):
    for keyword, face_color, vertex_color, comment, end in itertools.product(
            ("OFF", "off", "Off"), ("", " 0xff8000", " 0X00ff0080", " 255 128 0"), ("", " 0x10ff20ff"), (False, True),
            ("\n", "\r\n")):
        if keyword == "OFF" and not (vertex_color or "0x" in face_color.lower()):
            continue
        points, faces = cube(random)
        key = ("C" if keyword != "off" else "c") * bool(vertex_color) + keyword
        lines = [key] + ["# made by a test"] * comment + [f"{len(points)} {len(faces)} 0"]
        lines += [" ".join("%g" % x for x in p) + vertex_color for p in points]
        lines += [" ".join(map(str, [3] + f)) + face_color for f in faces]
        name = f"off-{key}-{face_color.strip().replace(' ', '_')}-{comment:d}{len(end)}"
        yield name, ((end.join(lines) + end).encode(), points, faces), keyword == "OFF" and not (
            face_color or vertex_color or comment)


def read_off(data):
    lines = [line.split(b"#")[0].split() for line in data.splitlines()]
    lines = [words for words in lines if words]
    return [tuple(map(float, words[:3])) for words in lines[2:2 + int(lines[1][0])]]


# --- clouds -----------------------------------------------------------------------------------------------------------

HEADERS = ["", "X Y Z\n", "x{s}y{s}z\n", "//X Y Z\n", "% of MATLAB\n", "# a comment\n", "{n}\n", "{n}\nx{s}y{s}z\n"]


def cloud_files(random):
    extensions = itertools.cycle(("xyz", "txt", "asc", "pts", "csv", "xyzn", "xyzrgb"))
    for header, gap, label, missing in itertools.product(HEADERS, (" ", ",", ";", "\t"), (None, 0, 1), (False, True)):
        if not (header or label is not None or missing):
            continue
        points = cube(random)[0] + [tuple(random.uniform(-1, 1) for _ in range(3)) for _ in range(4)]
        points = [tuple(round(x, 4) for x in p) for p in points]
        if missing:
            points[3:3] = [None]
        rows = [[repr(x) for x in p] if p else ["nan", "NaN", "nan"] for p in points]
        if label is not None:
            rows = [["p%d" % i] + row if label == 0 else row + ["tree"] for i, row in enumerate(rows)]
        names = header.format(s=gap, n=len(points))
        if label == 0 and "{s}" in header:
            names = names.replace("x" + gap, "name" + gap + "x" + gap, 1)
        elif label == 1 and "{s}" in header:
            names = names.replace("z\n", "z" + gap + "label\n")
        data = names + "".join(gap.join(row) + "\n" for row in rows)
        where = f"{HEADERS.index(header)}-{' ,;'.find(gap)}-{label}-{missing:d}"
        yield f"cloud-{where}", next(extensions), (data.encode(), points, [])
    for i, row in enumerate(("0,5 1,5 2,5", "0,5\t1,5\t2,5", "1 2 3\n0,5 1 2", "0,5;1,5;2,5", "1,0 2,0 3,0 4,0")):
        yield f"commas-{i}", "txt", (row + "\n").encode()


def read_cloud(data):
    points = []
    for line in data.decode().splitlines():
        words = re.split(r"[\s,;]+", re.split(r"%|#|//", line)[0].strip())
        numbers = [word for word in words if re.fullmatch(r"nan|[-+]?\d[-+.\de]*", word, re.I)]
        if len(numbers) >= 3:
            points.append(tuple(map(float, numbers[:3])))
    return points


def pcd_files(random):
    for data, number, extra, missing in itertools.product(
            ("ascii", "binary"), ("F 4", "F 8"), (None, "U 1", "I 2", "U 4", "F 8"), (False, True)):
        points = cube(random)[0] + ([None] if missing else [])
        kind, size = number.split()
        codes = {"F 4": "f", "F 8": "d", "U 1": "B", "I 2": "h", "U 4": "I"}
        fields = ["x", "y", "z"] + (["other"] if extra else [])
        types = [(kind, size)] * 3 + ([tuple(extra.split())] if extra else [])
        head = ["# .PCD v0.7", "VERSION 0.7", "FIELDS " + " ".join(fields), "SIZE " + " ".join(t[1] for t in types),
                "TYPE " + " ".join(t[0] for t in types), "COUNT " + " ".join("1" for _ in types),
                f"WIDTH {len(points)}", "HEIGHT 1", "VIEWPOINT 0 0 0 1 0 0 0", f"POINTS {len(points)}", f"DATA {data}"]
        rows = [(p or (NAN,) * 3) + ((i,) if extra else ()) for i, p in enumerate(points)]
        body = "".join(" ".join("%g" % x for x in row) + "\n" for row in rows).encode()
        if data == "binary":
            body = b"".join(struct.pack("<" + "".join(codes[" ".join(t)] for t in types), *row) for row in rows)
        name = f"pcd-{data}-{size}-{(extra or 'none').replace(' ', '')}-{missing:d}"
        yield name, "pcd", ("\n".join(head).encode() + b"\n" + body, points, [])


def read_pcd(data):
    head, mode, body = re.match(rb"(.*?\nDATA (\w+)\n)(.*)", data, re.S).groups()
    lines = {words[0]: words[1:] for words in map(str.split, head.decode().splitlines())}
    if mode == b"ascii":
        return [tuple(map(float, line.split()[:3])) for line in body.splitlines()]
    codes = {("F", "4"): "f", ("F", "8"): "d", ("U", "1"): "B", ("I", "2"): "h", ("U", "4"): "I"}
    row = struct.Struct("<" + "".join(codes[t] for t in zip(lines["TYPE"], lines["SIZE"])))
    return [row.unpack_from(body, i * row.size)[:3] for i in range(int(lines["POINTS"][0]))]


def ptx_files(random):
    for shift, intensity, colors, missing in itertools.product((5, 10), (False, True), (False, True), (False, True)):
        if colors and not intensity:
            continue
        points = cube(random)[0] + ([None] if missing else [])
        rows = [tuple(x - (shift if k == 0 else 0) for k, x in enumerate(p)) if p else (0, 0, 0) for p in points]
        head = f"{len(points)}\n1\n{shift} 0 0\n1 0 0\n0 1 0\n0 0 1\n1 0 0 0\n0 1 0 0\n0 0 1 0\n{shift} 0 0 1\n"
        tail = " 0.5" * intensity + " 255 0 7" * colors
        text = head + "".join("%g %g %g" % row + tail + "\n" for row in rows)
        if intensity:
            yield f"ptx-{shift}-{colors:d}{missing:d}", "ptx", (text.encode(), points, [])


def read_ptx(data):
    lines = data.decode().splitlines()
    shift = float(lines[9].split()[0])
    rows = [tuple(map(float, line.split()[:3])) for line in lines[10:]]
    return [(x + shift, y, z) if (x, y, z) != (0, 0, 0) else (NAN,) * 3 for x, y, z in rows]


# --- glTF -------------------------------------------------------------------------------------------------------------

def gltf_files(random):
    ways = ("chunk", "glb-embedded", "embedded", "embedded-plain", "beside", "beside-escaped")
    for way, code, indented, split in itertools.product(ways, ("B", "H", "I"), (None, 2), (False, True)):
        points, faces = cube(random)
        flat = b"".join(struct.pack("<3f", *p) for p in points)
        index = struct.pack("<36" + code, *sum(faces, []))
        index += b"\0" * (-len(index) % 4)
        buffers = [flat, index] if split and way != "chunk" else [flat + index]
        component = {"B": 5121, "H": 5123, "I": 5125}[code]
        views = [{"buffer": 0, "byteLength": len(flat)},
                 {"buffer": len(buffers) - 1, "byteOffset": 0 if len(buffers) == 2 else len(flat),
                  "byteLength": 36 * struct.calcsize(code)}]
        document = {"asset": {"version": "2.0", "generator": "a test"}, "scene": 0, "scenes": [{"nodes": [0]}],
                    "nodes": [{"mesh": 0, "name": "cube"}],
                    "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
                    "accessors": [{"bufferView": 0, "componentType": 5126, "count": 8, "type": "VEC3", "min": [0, 0, 0],
                                   "max": [1, 1, 1]},
                                  {"bufferView": 1, "componentType": component, "count": 36, "type": "SCALAR"}],
                    "bufferViews": views, "buffers": [{"byteLength": len(b)} for b in buffers], "extras": {"k": [1.50]}}
        name, beside = f"gltf-{way}-{code}{indented or 0}{split:d}", {}
        for i, buffer in enumerate(buffers if way != "chunk" else []):
            mime = "application/octet-stream" if way == "embedded" else "application/gltf-buffer"
            document["buffers"][i]["uri"] = f"data:{mime};base64," + base64.b64encode(buffer).decode()
            if way.startswith("beside"):
                file = f"{name} {i}.bin" if way == "beside-escaped" else f"{name}_{i}.bin"
                beside[file] = buffer
                document["buffers"][i]["uri"] = file.replace(" ", "%20")
        text = json.dumps(document, indent=indented).encode()
        if way in ("chunk", "glb-embedded"):
            text += b" " * (-len(text) % 4)
            chunks = struct.pack("<II", len(text), 0x4E4F534A) + text
            if way == "chunk":
                chunks += struct.pack("<II", len(buffers[0]), 0x004E4942) + buffers[0]
            text = b"glTF" + struct.pack("<II", 2, 12 + len(chunks)) + chunks
        if not (way == "chunk" and split):
            yield name, "glb" if "glb" in way or way == "chunk" else "gltf", (text, points, faces), beside


def read_gltf(data, folder):
    chunk = b""
    if data[:4] == b"glTF":
        size = struct.unpack_from("<I", data, 12)[0]
        chunk, data = data[28 + size:], data[20:20 + size]
    document = json.loads(data)
    accessor = document["accessors"][document["meshes"][0]["primitives"][0]["attributes"]["POSITION"]]
    view = document["bufferViews"][accessor["bufferView"]]
    uri = document["buffers"][view["buffer"]].get("uri")
    if uri and uri.startswith("data:"):
        chunk = base64.b64decode(uri.split(",", 1)[1])
    elif uri:
        with open(os.path.join(folder, uri.replace("%20", " ")), "rb") as file:
            chunk = file.read()
    at = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
    return [struct.unpack_from("<3f", chunk, at + 12 * i) for i in range(accessor["count"])]


# --- all of them -------------------------------------------------------------------------------------------------------

def wild_files():
    dice = random.Random(SEED)
    for extension, files in (("ply", ply_files), ("obj", obj_files), ("stl", stl_files), ("off", off_files)):
        for name, (data, points, faces), assimp in files(dice):
            yield Wild(name, extension, data, points, faces, assimp)
    for name, extension, made in cloud_files(dice):
        if isinstance(made, bytes):
            yield Wild(name, extension, made, [], [], refused="write decimals with points, not commas|commas and semic")
        else:
            yield Wild(name, extension, *made)
    for files in (pcd_files, ptx_files):
        for name, extension, made in files(dice):
            yield Wild(name, extension, *made)
    for name, extension, made, beside in gltf_files(dice):
        yield Wild(name, extension, *made, assimp="beside-escaped" not in name and "glb-embedded" not in name, beside=beside)


def read(extension, data, folder):
    readers = {"ply": read_ply, "obj": read_obj, "stl": read_stl, "off": read_off, "pcd": read_pcd, "ptx": read_ptx}
    if extension in ("glb", "gltf"):
        return read_gltf(data, folder)
    return readers.get(extension, read_cloud)(data)

"""What assimp 5.2.5, OpenMesh 9.0 and Blender 3.4.1 are known to read otherwise, each with its reason.

Where it can be said what a program makes of the file, the expectation is changed and the comparison stays as strict;
only lines that nothing can be expected of are let through, by KNOWN.
"""
import dataclasses
import re

import numpy as np

from opened_elsewhere.shapes import Shape


@dataclasses.dataclass
class File:
    name: str
    source_format: str
    format: str
    moment: str


ALL = ("ply", "obj", "glb", "stl", "off")
# Programs, formats, names of sources, the whole line, and why it is none of Knead's doing.
KNOWN = [
    (("openmesh",), ALL, "", r"PolyMeshT::add_face: .*", "OpenMesh remarks on faces that are not manifold"),
    (("openmesh",), ALL, "", r"ImporterT: Face has equal vertices|\d+The reader encountered invalid faces.*",
     "OpenMesh remarks on faces that name a vertex twice"),
    (("openmesh",), ("ply",), "", r"Unexpected end of file while reading\.|OpenMesh: cannot read it",
     "OpenMesh 9.0 skips too few bytes of a face's texcoord list"),
    (("openmesh",), ("off",), "fixed_top_face_colors", r"faces: .*|area .*|volume .*",
     "OpenMesh takes colours of faces for further faces, unless the keyword is COFF"),
    (("openmesh",), ("obj", "off"), "spider.obj|pirate", r"(uv|normal): \d+ of \d+ differ",
     "OpenMesh repeats the vertices of faces that are not manifold without their attributes"),
    (("openmesh", "assimp", "blender"), ("obj",), "pirate|concave|fuze|duck|negative", r".*[Mm]aterial.*",
     "the source's material file is not there"),
    (("assimp",), ("obj",), "fuze", r".*Invalid opacity value.*", "the source's material file says Tr 0"),
    (("assimp",), ALL, "", r".*There are unreferenced vertices", "vertices without faces are the source's"),
    (("assimp",), ("ply", "obj", "off"), "points.xyz", r".*no (valid )?faces", "assimp reads points only from GLB"),
    (("assimp",), ("off",), "concave_polygon", r".*", "assimp leaves out faces of more than 9 corners in OFF"),
    (("assimp",), ("off",), "fairing_cross_binary", r".*", "assimp reads no binary OFF"),
    (("assimp", "openmesh"), ("ply",), "cow_tristrips", r".*", "assimp and OpenMesh read no tristrips"),
    (("blender",), ("ply",), "cow_tristrips", r".*", "Blender's strips do not turn every other triangle round"),
    (("blender",), ("ply",), "", r"normal: missing", "Blender 3.4 reads no normals from PLY"),
    (("blender",), ("ply",), "", r"uv: missing", "Blender 3.4 reads s and t of vertices, no texcoord of faces"),
    (("blender",), ("obj",), "concave_polygon", r"faces: 1 missing, .*",
     "Blender divides polygons of OBJ that name a vertex twice"),
    (("assimp", "openmesh", "blender"), ("ply", "off"), "fixed_top_face_colors", r"color: missing",
     "colours of faces are read by none"),
    (("numpy",), ("xyz",), "fuze", r"normal: not in the file",
     "normals that are not unit are further columns to Knead"),
    (("assimp",), ("off",), ".glb$|.obj$|suzanne", r"(uv|color): \d+ of \d+ differ",
     "assimp takes the last number of a normal in OFF for the first of what follows"),
]


def face_starts(shape):
    return np.cumsum(shape.sizes) - shape.sizes


def only_faces(shape, keep):
    corners = np.repeat(keep, shape.sizes)
    rows = [a[corners] if len(a) else a for a in (shape.uv, shape.color, shape.normal)]
    return Shape(shape.positions, shape.sizes[keep], shape.corners[corners], *rows)


def without_repeated_vertices(shape, ids):
    """Neither OpenMesh nor Blender has faces that come to one vertex twice."""
    keep = np.array([len(set(ids[c:c + n].tolist())) == n for c, n in zip(face_starts(shape), shape.sizes)], bool)
    return only_faces(shape, keep)


def without_duplicates(shape, ids):
    """Blender's validate(), which the import of OBJ does not call so, keeps one of the faces with the same vertices."""
    seen, keep = set(), []
    for c, n in zip(face_starts(shape), shape.sizes):
        face = tuple(sorted(ids[c:c + n].tolist()))
        keep.append(face not in seen)
        seen.add(face)
    return only_faces(shape, np.array(keep, bool))


def welded(shape):
    """The vertices as STL readers find them again: equal as floats."""
    return np.unique(shape.positions.astype(np.float32) + 0.0, axis=0, return_inverse=True)[1].reshape(-1)


def as_read(program, file, expected, bars):
    """The shape that the program should make of it, and the bars of its attributes."""
    bars = dict(bars)
    triangulated = file.format in ("stl", "glb") and (expected.sizes > 3).any()
    if program != "assimp" and len(expected.sizes) and not triangulated:
        ids = (welded(expected) if file.format == "stl" else np.arange(len(expected.positions)))[expected.corners]
        expected = without_repeated_vertices(expected, ids)
        if program == "blender" and file.format != "obj":
            ids = (welded(expected) if file.format == "stl" else np.arange(len(expected.positions)))[expected.corners]
            expected = without_duplicates(expected, ids)
    if program == "openmesh":
        bars["color"] = 1.01 / 255  # real colours are cut off to bytes
    if program == "blender":
        bars["color"] = 1.25 / 255  # bytes in sRGB, whose slope is up to 2.4
        bars["normal"] = 2e-2  # custom normals are two angles of 16 bits, relative to Blender's own
    return expected, bars


def srgb_of(linear):
    return np.where(linear <= 0.0031308, linear * 12.92, 1.055 * np.maximum(linear, 1e-9) ** (1 / 2.4) - 0.055)


def as_written(program, file, got):
    """What was read, in the numbers of the file."""
    if program == "blender" and len(got.color):
        rgb = got.color[:, :3]
        if file.format == "obj":  # taken for sRGB and kept linear
            got.color = np.hstack([srgb_of(rgb), got.color[:, 3:]])
        if file.format == "glb":  # taken for linear and kept as bytes in sRGB
            linear = np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)
            got.color = np.hstack([linear, got.color[:, 3:]])
    if program == "assimp" and file.format == "off" and got.color.max(initial=0) > 1:
        got.color = got.color / 255  # bytes stay 0 to 255
    if program == "assimp" and file.format == "stl":
        got.normal = np.zeros((0, 3))  # those of the triangles, which compare.facet_normals looks at
    return got


def reason(program, file, line):
    for owners, formats, names, pattern, why in KNOWN:
        if program in owners and file.format in formats and re.search(names, file.name) and re.fullmatch(pattern, line):
            return why
    return ""

"""What differs between the shape that should have been read and the one that was."""
import collections

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

SAMPLES = 20000  # corners whose attributes are compared, of a large shape
# uv and normals are floats of size about 1, and some programs read text to 7 digits; colours are bytes in some.
ATTRIBUTE_BARS = {"uv": 1e-5, "color": 0.51 / 255, "normal": 1e-4}


def bar_of(expected):
    """1e-6 of the diagonal, and half a bit of the largest coordinate as a float."""
    if not len(expected.positions):
        return 0.0
    box = np.ptp(expected.positions, axis=0)
    return 1e-6 * np.sqrt(box @ box) + 2.0**-24 * np.abs(expected.positions).max()


def places_of(positions, bar):
    """A number for each position, the same for those that the bar cannot tell apart."""
    pairs = cKDTree(positions).query_pairs(4 * bar, output_type="ndarray")
    ones = np.ones(len(pairs))
    graph = coo_matrix((ones, (pairs[:, 0], pairs[:, 1])), (len(positions),) * 2)
    return connected_components(graph, directed=False)[1]


def faces_of(sizes, corner_places):
    """How often each face is there: its places in order, the smallest rotation of them."""
    starts = np.cumsum(sizes) - sizes
    found = collections.Counter()
    for size in np.unique(sizes):
        rows = corner_places[starts[sizes == size][:, None] + np.arange(size)]
        best = rows
        for turn in range(1, size):
            other = np.roll(rows, turn, axis=1)
            first = (other != best).argmax(axis=1)
            at = np.arange(len(rows))
            less = other[at, first] < best[at, first]
            best = np.where(less[:, None], other, best)
        unique, counts = np.unique(best, axis=0, return_counts=True)
        found.update(dict(zip(map(tuple, unique.tolist()), counts.tolist())))
    return found


def border_of(faces):
    """Directed edges, opposite ones cancelled: the same for polygons and the triangles that they fall into."""
    edges = collections.Counter()
    for face, count in faces.items():
        for a, b in zip(face, face[1:] + face[:1]):
            if a != b:
                edges[min(a, b), max(a, b)] += count if a < b else -count
    return {edge: count for edge, count in edges.items() if count}


def area_and_volume(shape):
    """Of triangles; the volume about the middle of the box."""
    middle = (shape.positions.min(axis=0) + shape.positions.max(axis=0)) / 2
    a, b, c = (shape.positions[shape.corners.reshape(-1, 3)[:, i]] - middle for i in range(3))
    normal = np.cross(b - a, c - a)
    return np.sqrt((normal**2).sum(axis=1)).sum() / 2, (a * np.cross(b, c)).sum() / 6


def unit(rows):
    """Zero stays zero."""
    length = np.sqrt((rows**2).sum(axis=1))[:, None]
    return rows / np.where(length > 0, length, 1)


def facet_normals(got, bar):
    """Of an STL file: its normals against those of its triangles, but for slivers, whose floats say too little."""
    if not len(got.normal) or (got.sizes != 3).any():
        return []
    a, b, c = (got.positions[got.corners.reshape(-1, 3)[:, i]] for i in range(3))
    cross = np.cross(b - a, c - a)
    longest = np.sqrt(max_squared(b - a, c - b, a - c))
    height = np.sqrt((cross**2).sum(axis=1)) / np.where(longest > 0, longest, 1)
    off = np.abs(got.normal[::3] - unit(cross)).max(axis=1)
    bad = (off > 1e-2) & (height > 1000 * bar)
    return [f"{bad.sum()} normals of triangles differ"] if bad.any() else []


def max_squared(*edges):
    return np.max([(e**2).sum(axis=1) for e in edges], axis=0)


def compare_faces(expected_faces, got_faces, triangulated):
    if triangulated:
        fan = sum(max(len(f) - 2, 0) * n for f, n in expected_faces.items())
        count = sum(got_faces.values())
        lines = [f"{count} triangles, not {fan}"] if count != fan else []
        same = border_of(expected_faces) == border_of(got_faces)
        return lines + ([] if same else ["the triangles do not make up the faces"])
    missing, extra = expected_faces - got_faces, got_faces - expected_faces
    if not missing and not extra:
        return []
    return [f"faces: {sum(missing.values())} missing, {sum(extra.values())} extra"]


def compare_attribute(name, expected, got, bar, attribute_bar):
    want, have = getattr(expected, name), getattr(got, name)
    if name == "normal":
        # Readers make normals unit, and invent one where the file has zero.
        want, have = unit(want), unit(have)
        want = np.where((want == 0).all(axis=1)[:, None], np.nan, want)
    width = min(want.shape[1], have.shape[1], 3)  # alpha is not in the OBJ file
    known = np.isfinite(want).all(axis=1)
    items, at = expected.items()[known], np.arange(len(have))
    if len(at) > SAMPLES:
        at = np.random.default_rng(1).choice(at, SAMPLES, replace=False)
    scale = attribute_bar * np.maximum(1, np.abs(want[known, :width]).max(initial=1))
    tree = cKDTree(np.hstack([expected.positions[items] / (2 * bar), want[known, :width] / scale]))
    rows = np.hstack([got.positions[got.items()[at]] / (2 * bar), have[at, :width] / scale])
    far = tree.query(rows, p=np.inf)[0] > 1
    blank = np.isin(got_places(expected, got)[at], expected.items()[~known])
    far &= ~blank
    return [f"{name}: {far.sum()} of {len(at)} differ"] if far.any() else []


def got_places(expected, got):
    return cKDTree(expected.positions).query(got.positions[got.items()])[1]


def compare_sizes(got, info, bar):
    if not len(got.sizes) or (got.sizes != 3).any():
        return []
    area, volume = area_and_volume(got)
    lines = []
    if abs(area - info["area"]) > 8 * bar * info["diagonal"] + 1e-5 * info["area"]:
        lines.append(f"area {area:.9g}, not {info['area']:.9g}")
    if info["volume"] is not None and abs(volume - info["volume"]) > bar * info["area"]:
        lines.append(f"volume {volume:.9g}, not {info['volume']:.9g}")
    return lines


def compare(expected, got, info, attribute_bars):
    """Lines that say what differs. `info` is Knead's of the file: attributes, area and volume are taken from it."""
    if not len(got.positions):
        return ["nothing was read"]
    bar = bar_of(expected)
    distance, nearest = cKDTree(expected.positions).query(got.positions)
    if distance.max() > bar:
        return [f"{(distance > bar).sum()} positions differ, by up to {distance.max():.3g} (bar {bar:.3g})"]
    places = places_of(expected.positions, bar)
    lines = []
    if len(expected.sizes) and info["faces"]:
        want = faces_of(expected.sizes, places[expected.corners])
        have = faces_of(got.sizes, places[nearest[got.corners]])
        lines += compare_faces(want, have, (expected.sizes > 3).any() and info["format"] in ("stl", "glb"))
    else:
        missing = len(np.setdiff1d(places, places[nearest]))
        lines += [f"{missing} positions missing"] if missing else []
    lines += compare_sizes(got, info, bar)
    for name, attribute_bar in attribute_bars.items():
        want, have = name in info["attributes"], len(getattr(got, name)) > 0
        if want != have:
            lines.append(f"{name}: {'missing' if want else 'not in the file'}")
        elif want and len(getattr(expected, name)):
            lines += compare_attribute(name, expected, got, bar, attribute_bar)
    return lines

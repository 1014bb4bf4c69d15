#!/usr/bin/env python3
"""Agreement of `knead deform` with an independent integration. Run by hand; not part of ctest.

    /usr/bin/python3 tests/acceptance/check_agreement.py build/release/knead ../shared/meshes

Needs numpy and scipy. Nothing here shares code with Knead: the fields are written down from the method,
meshes are read by the few lines below, and path lines are integrated by scipy's DOP853 at 1e-13. Each case
runs on a whole mesh; the vertices integrated here are a random sample of the moved ones and those where
Knead's own settings differ most from one another, so that the worst vertex of the mesh is among them.

Options: --samples N (60; all meshes then take about an hour on two free cores), --mesh NAME and --case NAME (only those), --jobs N (2), --seed N, --keep DIR.
Exit code 0: every check passed.
"""
import argparse
import json
import multiprocessing
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time

import numpy as np
from scipy.integrate import solve_ivp

MESHES = ["bunny_35k", "armadillo_43k", "hand_50k", "fandisk_6k", "dragon_50k", "camel_35k"]
FRACTION = 0.4867502159528536

DEFAULT_BAR = 2e-5  # of the box diagonal
DOUBLE_BAR = 1e-8


# Meshes -----------------------------------------------------------------------------------------------

def read_ply(path):
    """Binary little-endian PLY: positions in the file's own type, faces as an array of triangles."""
    with open(path, "rb") as file:
        data = file.read()
    end = data.index(b"end_header\n") + len(b"end_header\n")
    kinds = {"float": "<f4", "float32": "<f4", "double": "<f8", "float64": "<f8",
             "uchar": "u1", "uint8": "u1", "int": "<i4", "int32": "<i4", "uint": "<u4"}
    count, faces, fields, element = 0, 0, [], ""
    lists = []
    for line in data[:end].decode("latin-1").split("\n"):
        words = line.split()
        if words[:1] == ["format"]:
            assert words[1] == "binary_little_endian", words
        if words[:1] == ["element"]:
            element = words[1]
            if element == "vertex":
                count = int(words[2])
            if element == "face":
                faces = int(words[2])
        if words[:1] == ["property"]:
            if element == "vertex":
                fields.append((words[2], kinds[words[1]]))
            elif element == "face":
                lists.append((kinds[words[2]], kinds[words[3]]))
    vertices = np.frombuffer(data, np.dtype(fields), count, end)
    points = np.stack([vertices[k] for k in "xyz"], 1)
    triangles = np.zeros((0, 3), int)
    if faces:
        rows = np.frombuffer(data, np.dtype([("n", lists[0][0]), ("i", lists[0][1], 3)]), faces,
                             end + vertices.nbytes)
        assert (rows["n"] == 3).all()
        triangles = rows["i"].astype(int)
    return points, triangles


def write_ply(path, points, triangles):
    header = ("ply\nformat binary_little_endian 1.0\nelement vertex %d\nproperty float x\nproperty float y\n"
              "property float z\nelement face %d\nproperty list uchar int vertex_indices\nend_header\n")
    rows = np.zeros(len(triangles), [("n", "u1"), ("i", "<i4", 3)])
    rows["n"], rows["i"] = 3, triangles
    with open(path, "wb") as file:
        file.write((header % (len(points), len(triangles))).encode())
        file.write(points.astype("<f4").tobytes() + rows.tobytes())


# Fields: v = w u + (dw/dr) grad r x A -----------------------------------------------------------------

def unit(a):
    a = np.asarray(a, float)
    return a / np.sqrt(a @ a)


def dot(a, b):
    return (a * b).sum(-1)


def cross(a, b):
    a, b = np.broadcast_arrays(a, b)
    return np.stack([a[..., 1] * b[..., 2] - a[..., 2] * b[..., 1],
                     a[..., 2] * b[..., 0] - a[..., 0] * b[..., 2],
                     a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]], -1)


def turned(v, axis, angle):
    return v * np.cos(angle) + np.cross(axis, v) * np.sin(angle) + axis * (axis @ v) * (1 - np.cos(angle))


def assembled(r, grad, u, a, inner, outer):
    s = np.clip((r - inner) / (outer - inner), 0, 1)
    b = 4 * s**3 - 3 * s**4
    w = (1 - b) ** 2
    slope = -2 * (1 - b) * 12 * s * s * (1 - s) / (outer - inner)
    return w[:, None] * u + slope[:, None] * cross(grad, a)


def ball(x, c):
    d = x - c
    r = np.sqrt(dot(d, d))
    return r, d / np.where(r > 0, r, 1)[:, None]


def capsule(x, c, h):
    d = x - c
    s = np.clip(d @ h / (h @ h), -1, 1)
    return ball(d, s[:, None] * h)


def curve(x, polyline):
    """(3/4 sum of the integrals of |x-y|^-5)^(-1/4) and its gradient, by Gauss-Legendre quadrature in z,
    l = h sinh z: the integrand is then h^-4 cosh^-4 z, smooth and at most 1, wherever x lies. Beyond an end
    and near the line the panels follow l itself, on which the distance at most doubles."""
    total, slope = np.zeros(len(x)), np.zeros_like(x)
    nodes, weights = np.polynomial.legendre.leggauss(20)
    for p, q in zip(polyline[:-1], polyline[1:]):
        length = np.sqrt((q - p) @ (q - p))
        e = (q - p) / length
        foot = (x - p) @ e
        across = x - p - foot[:, None] * e
        h = np.maximum(np.sqrt(dot(across, across)), 1e-9 * length)  # a vertex may lie on the curve
        low, high = -foot, length - foot
        side = np.where(low > 0, 1.0, np.where(high < 0, -1.0, 0.0))
        plain = (side != 0) & (h < 3 * np.minimum(abs(low), abs(high)))
        for chosen in (~plain, plain):
            index = np.flatnonzero(chosen)
            if len(index) == 0:
                continue
            along, hh = side[index], h[index]
            if chosen is plain:
                a, b = np.log(np.minimum(abs(low), abs(high))[index]), np.log(np.maximum(abs(low), abs(high))[index])
            else:
                a, b = np.arcsinh(low[index] / hh), np.arcsinh(high[index] / hh)
            panels = max(1, int(np.ceil((b - a).max() / 1.0)))
            for k in range(panels):
                z = (a + (b - a) * k / panels)[:, None] + ((b - a) / panels)[:, None] * (nodes + 1) / 2
                dz = ((b - a) / panels / 2)[:, None] * weights
                if chosen is plain:
                    l, dl = along[:, None] * np.exp(z), np.exp(z) * dz
                else:
                    l, dl = hh[:, None] * np.sinh(z), hh[:, None] * np.cosh(z) * dz
                rr = np.sqrt(hh[:, None] ** 2 + l * l)
                total[index] += (dl * rr**-5).sum(1)
                seven = dl * rr**-7
                slope[index] -= 5 * (seven.sum(1)[:, None] * across[index] - (seven * l).sum(1)[:, None] * e)
    r = (0.75 * total) ** -0.25
    return r, (-0.25 * r**5 * 0.75)[:, None] * slope


def point_set(x, points, curves, m):
    rs, grads = [], []
    for p in points:
        r, g = ball(x, p)
        rs.append(r)
        grads.append(g)
    for line in curves:
        r, g = curve(x, line)
        rs.append(r)
        grads.append(g)
    rs, grads = np.array(rs), np.array(grads)
    least = rs.min(0)
    on = least == 0
    ratio = np.where(on, 1, least) / np.where(rs == 0, 1, rs)
    r = least * (ratio**m).sum(0) ** (-1.0 / m)
    grad = (((r / np.where(rs == 0, 1, rs)) ** (m + 1))[:, :, None] * grads).sum(0)
    return r, np.where(on[:, None], 0, grad)


class Segment:
    """velocity(x, t), region(x, t) -> r, and what a step and the outside may be judged by."""

    def __init__(self, velocity, region, inner, outer, speed=0.0, started=None, static=False):
        self.velocity, self.region = velocity, region
        self.inner, self.outer, self.speed = inner, outer, speed
        self.started = started  # which points are moved at all, by where they are when the stroke begins
        self.max_step = min(0.02 if not static else 0.05, (outer - inner) / speed / 6 if speed else 1)


def ball_or_capsule(stroke, c0, c1, blended):
    inner, outer = stroke.get("inner", 0.0), stroke["outer"]
    u = c1 - c0
    h = np.array(stroke["half_axis"], float) if stroke.get("region") == "capsule" else None

    def at(x, c):
        d = x - c
        potential = cross(u, d) / 2
        if h is None:
            r, grad = ball(x, c)
        else:
            r, grad = capsule(x, c, h)
            a = unit(h)
            along = (u @ a) * a
            other = cross(along, d) / 2 + (d @ np.cross(a, u - along))[:, None] * a
            g = stroke.get("gauge", 0)
            potential = g * potential + (1 - g) * other
        return assembled(r, grad, np.broadcast_to(u, x.shape), potential, inner, outer)

    def region(x, t):
        def one(c):
            return ball(x, c)[0] if h is None else capsule(x, c, h)[0]
        return np.minimum(one(c0), one(c1)) if blended else one(c0 + t * u)

    if blended:
        def velocity(x, t):
            return (1 - t) * at(x, c0) + t * at(x, c1)
    else:
        def velocity(x, t):
            return at(x, c0 + t * u)
    return Segment(velocity, region, inner, outer, np.sqrt(u @ u))


def parts_of(points, curves, reach, together):
    """Components of the elements under distance < reach: list of (points, curves, barycentre)."""
    def dense(line):
        return np.concatenate([np.linspace(p, q, 200) for p, q in zip(line[:-1], line[1:])])
    elements = [("p", p, p[None]) for p in points] + [("c", c, dense(c)) for c in curves]
    label = list(range(len(elements)))
    if together:
        label = [0] * len(elements)
    else:
        for i in range(len(elements)):
            for j in range(i):
                gap = np.sqrt(((elements[i][2][:, None] - elements[j][2][None]) ** 2).sum(-1)).min()
                if gap < reach and label[i] != label[j]:
                    old, new = label[i], label[j]
                    label = [new if k == old else k for k in label]
    result = []
    for k in sorted(set(label)):
        p = [e[1] for e, l in zip(elements, label) if l == k and e[0] == "p"]
        c = [e[1] for e, l in zip(elements, label) if l == k and e[0] == "c"]
        result.append((p, c, barycentre(p, c, reach)))
    return result


def barycentre(points, curves, outer):
    """A point weighs 1, a piece of a curve its length / outer (docs/mathematics.md)."""
    weighted = [(1.0, p) for p in points]
    for line in curves:
        weighted += [(np.sqrt((q - p) @ (q - p)) / outer, (p + q) / 2) for p, q in zip(line[:-1], line[1:])]
    return np.average([p for _, p in weighted], axis=0, weights=[w for w, _ in weighted])


def segments_of(stroke):
    tool = stroke["tool"]
    if tool == "implicit":
        path = np.array(stroke["path"], float)
        return [ball_or_capsule(stroke, p, q, stroke.get("time") == "blended")
                for p, q in zip(path[:-1], path[1:]) if (p != q).any()]
    if tool == "paint":
        result = []
        for sample in stroke["samples"]:
            c0 = np.array(sample["point"], float)
            result.append(ball_or_capsule(stroke, c0, c0 - stroke["depth"] * unit(sample["normal"]), False))
        return result
    if tool == "points":
        points = [np.array(p, float) for p in stroke.get("points", [])]
        curves = [np.array(c, float) for c in stroke.get("curves", [])]
        m, inner, outer = stroke.get("exponent", 8), stroke.get("inner", 0.0), stroke["outer"]
        result = []
        for move in stroke["displacements"]:
            u = np.array(move, float)
            if (u == 0).all():
                continue
            parts = parts_of(points, curves, outer, stroke.get("center") == "barycentre")

            def velocity(x, t, u=u, parts=parts):
                v = np.zeros_like(x)
                for p, c, centre in parts:
                    y = x - t * u
                    r, grad = point_set(y, p, c, m)
                    v += assembled(r, grad, np.broadcast_to(u, x.shape), cross(u, y - centre) / 2, inner, outer)
                return v

            def region(x, t, u=u, parts=parts):
                return np.min([point_set(x - t * u, p, c, m)[0] for p, c, _ in parts], axis=0)
            result.append(Segment(velocity, region, inner, outer, np.sqrt(u @ u)))
            points = [p + u for p in points]
            curves = [c + u for c in curves]
        return result

    c = np.array(stroke["center"], float)
    a = unit(stroke["axis"])
    if tool == "rotate":
        omega, g = np.radians(stroke["angle_deg"]), stroke.get("gauge", 0)

        def inside(d):
            h = (d @ a)[:, None]
            across = d - h * a
            return omega * cross(a, d), (g * omega / 2 * (h * across - dot(across, across)[:, None] / 2 * a)
                                         + (1 - g) * omega * h * d)
        speed = 0
    if tool == "stretch":
        matrix = np.log(stroke["factor"]) * (np.outer(a, a) - (np.eye(3) - np.outer(a, a)) / 2)

        def inside(d):
            return d @ matrix.T, cross(d @ matrix.T, d) / 3
    if tool in ("rotate", "stretch"):
        inner, outer = stroke["inner"], stroke["outer"]

        def velocity(x, t):
            return assembled(*ball(x, c), *inside(x - c), inner, outer)
        return [Segment(velocity, lambda x, t: ball(x, c)[0], inner, outer, static=True)]

    n = unit(stroke.get("normal", stroke["axis"]))
    if tool == "twist":
        tau, g = np.radians(stroke["rate_deg"]), stroke.get("gauge", 0)
        inner, outer, half = stroke["inner"], stroke["outer"], 0.0

        def inside(d):
            h = (d @ a)[:, None]
            across = d - h * a
            q = dot(across, across)[:, None]
            return tau * h * cross(a, d), g * tau / 4 * (h * h * across - q * h * a) - (1 - g) * tau / 2 * h * q * a
    else:
        omega, g = np.radians(stroke["angle_deg"]), stroke.get("gauge", 1)
        half = omega / 2
        if "width" in stroke:
            f = stroke.get("center_fraction", FRACTION)
            inner, outer = -f * stroke["width"], (1 - f) * stroke["width"]
        else:
            inner, outer = stroke["inner"], stroke["outer"]

        def inside(d):
            h = (d @ a)[:, None]
            across = d - h * a
            q = dot(across, across)[:, None]
            return omega * cross(a, d), g * omega / 2 * (h * across - q / 2 * a) - (1 - g) * omega / 2 * q * a

    def velocity(x, t):
        normal = turned(n, a, half * t)
        return assembled((x - c) @ normal, normal, *inside(x - c), inner, outer)

    def region(x, t):
        return (x - c) @ turned(n, a, half * t)
    started = None
    if "radius" in stroke:
        def started(x):
            d = x - c
            d = d - (d @ n)[:, None] * n
            return np.sqrt(dot(d, d)) <= stroke["radius"]
    return [Segment(velocity, region, inner, outer, started=started, static=True)]


def flow_of(events, until=None):
    """(segment, fraction of it) in order."""
    done, undone = [], []
    for event in events:
        if "undo" in event:
            for _ in range(event["undo"]):
                undone.append(done.pop())
        elif "redo" in event:
            for _ in range(event["redo"]):
                done.append(undone.pop())
        else:
            done.append(event)
            undone = []
    result = []
    for k, stroke in enumerate(done):
        segments = segments_of(stroke)
        share = 1.0 if until is None else min(max(until - k, 0.0), 1.0)
        for j, segment in enumerate(segments):
            part = min(max(share * len(segments) - j, 0.0), 1.0)
            if part > 0:
                result.append((segment, part))
    return result


def integrate(flow, x, diagonal, finer=1, together=75):
    x = np.array(x, float)
    for segment, part in flow:
        live = np.ones(len(x), bool) if segment.started is None else segment.started(x)
        # who can be reached at all is not guessed: everything is integrated, in chunks
        for chunk in np.array_split(np.flatnonzero(live), max(1, len(x) // together)):
            if len(chunk) == 0:
                continue

            def slope(t, y):
                return segment.velocity(y.reshape(-1, 3), t).ravel()
            done = solve_ivp(slope, (0.0, part), x[chunk].ravel(), method="DOP853", rtol=1e-13,
                             atol=1e-13 * diagonal, max_step=segment.max_step / finer)
            assert done.success, done.message
            x[chunk] = done.y[:, -1].reshape(-1, 3)
    return x


def agreement(flow, x, computed, diagonal, bar):
    """The distance of the computed points from the truth. DOP853's own estimate is blind to the jump of v's second
    derivative at the inner threshold: what lies beyond the bar is judged again by shorter and shorter steps."""
    truth = integrate(flow, x, diagonal)
    for finer in (16, 128):
        doubtful = np.flatnonzero(worst(computed, truth, diagonal) > bar / 4)
        doubtful = doubtful[np.argsort(-worst(computed, truth, diagonal)[doubtful])][:8]
        if len(doubtful):
            truth[doubtful] = integrate(flow, x[doubtful], diagonal, finer, 1)
    return worst(computed, truth, diagonal).max(), truth


def surely_outside(flow, x):
    """Points that no region ever reaches: r >= ro at moments so dense that nothing slips through."""
    outside = np.ones(len(x), bool)
    for segment, part in flow:
        moments = 60 if segment.speed else 90
        slack = 1.5 * segment.speed * part / moments
        for t in np.linspace(0, part, moments + 1):
            index = np.flatnonzero(outside)
            clear = segment.region(x[index], t) > segment.outer * (1 + 1e-9) + slack
            if segment.started is not None:
                clear |= ~segment.started(x[index])
            outside[index[~clear]] = False
    return outside


# Cases ------------------------------------------------------------------------------------------------

def limb_cylinders(points, triangles, diagonal, rng, tool):
    """A centre, an axis down a limb, thresholds and a radius that only the limb's part with r < outer fits in."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components
    middle = points.mean(0)
    best = None
    edges = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    far = np.argsort(-np.sqrt(((points - middle) ** 2).sum(1)))[: len(points) // 3]
    for tip in rng.choice(far, 60, replace=False):
        size = diagonal * rng.uniform(0.06, 0.12)
        near = np.sqrt(((points - points[tip]) ** 2).sum(1)) < 1.5 * size
        down = unit(points[near].mean(0) - points[tip] + 1e-9 * diagonal * rng.standard_normal(3))
        c = points[tip] + down * size
        outer = 0.2 * size
        low = (points - c) @ down < outer
        # a triangle counts as soon as one corner is low
        touched = low[triangles].any(1)
        kept = touched[np.arange(len(edges)) % len(triangles)]
        graph = coo_matrix((np.ones(kept.sum()), tuple(edges[kept].T)), shape=(len(points),) * 2)
        _, label = connected_components(graph, directed=False)
        limb = label == label[tip]
        inside = np.zeros(len(points), bool)
        inside[np.unique(triangles[touched])] = True
        d = points - c
        d = d - (d @ down)[:, None] * down
        away = np.sqrt(dot(d, d))
        widest = away[limb & inside].max()
        others = away[inside & ~limb]
        if len(others) == 0 or others.min() < 1.15 * widest or (limb & inside).sum() < 100:
            continue
        score = others.min() / widest * min(1, size / widest)
        if best is None or score > best[0]:
            best = (score, c, down, outer, size, widest, (widest + min(others.min(), 2 * widest)) / 2)
    if best is None:
        return None
    _, c, down, outer, size, widest, radius = best
    across = unit(np.cross(down, [0.3, 0.5, 0.8]))
    if tool == "bend":
        stroke = {"tool": "bend", "center": c, "axis": across, "normal": down, "angle_deg": 50,
                  "inner": -0.7 * size, "outer": outer, "radius": radius}
    else:
        stroke = {"tool": "twist", "center": c, "axis": down, "rate_deg": 50 / size, "inner": -0.4 * size,
                  "outer": outer, "radius": radius}
    return stroke, 0.6 * widest


def cases(points, triangles, diagonal, rng):
    """Name -> list of events, placed on the shape and as strong as people use them."""
    box_min, box_max = points.min(0), points.max(0)
    middle = (box_min + box_max) / 2
    d = diagonal

    def surface():
        return points[rng.integers(len(points))]

    def direction():
        return unit(rng.standard_normal(3))

    def path(pieces, step):
        where, heading, result = surface() - 0.1 * d * direction(), direction(), []
        for _ in range(pieces + 1):
            result.append(where)
            heading = unit(heading + 0.35 * rng.standard_normal(3) + 0.6 * (middle - where) / d)
            where = where + step * d * heading
        return result

    out = {}
    out["implicit-swept"] = [{"tool": "implicit", "inner": 0.08 * d, "outer": 0.22 * d, "path": path(8, 0.05)}]
    out["implicit-through"] = [{"tool": "implicit", "inner": 0.05 * d, "outer": 0.12 * d,
                                "path": [middle - 0.6 * d * (q := direction()), middle + 0.5 * d * q]}]
    out["implicit-steep"] = [{"tool": "implicit", "inner": 0.12 * d, "outer": 0.16 * d, "path": path(3, 0.06)}]
    out["implicit-blended"] = [{"tool": "implicit", "inner": 0.08 * d, "outer": 0.22 * d, "time": "blended",
                                "path": path(6, 0.05)}]
    h = 0.12 * d * direction()
    out["capsule"] = [{"tool": "implicit", "region": "capsule", "half_axis": h, "inner": 0.05 * d,
                       "outer": 0.13 * d, "path": path(4, 0.05)}]
    out["capsule-gauge"] = [{"tool": "implicit", "region": "capsule", "half_axis": h, "inner": 0.05 * d,
                             "outer": 0.16 * d, "gauge": 0.7, "path": path(3, 0.05)}]
    out["capsule-blended"] = [{"tool": "implicit", "region": "capsule", "half_axis": h, "inner": 0.05 * d,
                               "outer": 0.15 * d, "time": "blended", "path": path(3, 0.05)}]
    start = surface()
    order = np.argsort(((points - start) ** 2).sum(1))
    samples = [{"point": points[order[k]], "normal": unit(points[order[k]] - middle)}
               for k in range(0, min(1200, len(points) // 6), 150)]
    out["paint"] = [{"tool": "paint", "outer": 0.07 * d, "depth": -0.02 * d, "samples": samples},
                    {"tool": "paint", "outer": 0.12 * d, "depth": 0.06 * d,
                     "samples": [{"point": surface(), "normal": 7.5 * direction()} for _ in range(3)]}]
    one, two = surface(), surface()
    cloud = [one + 0.03 * d * rng.standard_normal(3) for _ in range(5)] \
        + [two + 0.03 * d * rng.standard_normal(3) for _ in range(4)]
    moves = [0.08 * d * direction(), 0.06 * d * direction()]
    out["points-parts"] = [{"tool": "points", "points": cloud, "outer": 0.11 * d, "displacements": moves}]
    out["points-barycentre"] = [{"tool": "points", "points": cloud[:7], "outer": 0.15 * d, "exponent": 4,
                                 "center": "barycentre", "displacements": moves[:1]}]
    line = [one + 0.05 * d * np.array([np.cos(s), np.sin(s), 0.3 * s]) for s in np.linspace(0, 4, 6)]
    out["points-curve"] = [{"tool": "points", "curves": [line], "outer": 0.12 * d, "displacements": moves}]
    out["points-and-curves"] = [{"tool": "points", "curves": [line, [two, two + 0.1 * d * direction()]],
                                 "points": cloud[:2], "outer": 0.12 * d, "inner": 0.03 * d, "exponent": 6,
                                 "displacements": moves}]
    out["rotate"] = [{"tool": "rotate", "center": surface(), "axis": 3 * direction(), "angle_deg": 140,
                      "inner": 0.05 * d, "outer": 0.25 * d}]
    out["rotate-gauge"] = [{"tool": "rotate", "center": surface(), "axis": direction(), "angle_deg": -110,
                            "inner": 0.1 * d, "outer": 0.3 * d, "gauge": 1}]
    out["stretch"] = [{"tool": "stretch", "center": surface(), "axis": direction(), "factor": 2.2,
                       "inner": 0.1 * d, "outer": 0.4 * d},
                      {"tool": "stretch", "center": surface(), "axis": direction(), "factor": 0.6,
                       "inner": 0, "outer": 0.3 * d}]
    out["twist"] = [{"tool": "twist", "center": middle, "axis": direction(), "rate_deg": 220 / d,
                     "inner": -0.25 * d, "outer": 0.3 * d}]
    out["twist-gauge"] = [{"tool": "twist", "center": middle, "axis": direction(), "rate_deg": -160 / d,
                           "inner": -0.2 * d, "outer": 0.2 * d, "gauge": 1}]
    axis = direction()
    out["twist-oblique"] = [{"tool": "twist", "center": middle, "axis": axis, "normal": axis + 0.3 * direction(),
                             "rate_deg": 140 / d, "inner": -0.2 * d, "outer": 0.3 * d, "gauge": 0.4}]
    normal = np.cross(axis, direction())
    out["bend"] = [{"tool": "bend", "center": middle, "axis": axis, "normal": 2 * normal, "width": 0.5 * d,
                    "angle_deg": 80}]
    out["bend-gauge"] = [{"tool": "bend", "center": middle + 0.05 * d * axis, "axis": axis, "normal": normal,
                          "width": 0.6 * d, "center_fraction": 0.386, "angle_deg": -45, "gauge": 0}]
    out["bend-thresholds"] = [{"tool": "bend", "center": middle, "axis": axis, "normal": normal, "inner": -0.1 * d,
                               "outer": 0.35 * d, "angle_deg": 60, "gauge": 0.5}]
    out["session"] = out["implicit-blended"] + out["rotate"] + [{"undo": 2}, {"redo": 1}] + out["points-parts"] \
        + out["twist"] + [{"undo": 1}] + out["bend"]
    for tool in ("bend", "twist"):
        found = limb_cylinders(points, triangles, diagonal, rng, tool)
        if found:
            out["limb-" + tool] = [found[0]]
            out["limb-" + tool + "-refused"] = [dict(found[0], radius=found[1])]
    return out


def write_session(path, events):
    def plain(value):
        if isinstance(value, np.ndarray):
            return [float(v) for v in value]
        if isinstance(value, (list, tuple)):
            return [plain(v) for v in value]
        if isinstance(value, dict):
            return {k: plain(v) for k, v in value.items()}
        if isinstance(value, np.floating):
            return float(value)
        return value
    with open(path, "w") as file:
        for event in [{"knead": 1}] + events:
            file.write(json.dumps(plain(event)) + "\n")
    return [plain(e) for e in events]


# Checks -----------------------------------------------------------------------------------------------

class Run:
    def __init__(self, knead, folder):
        self.knead, self.folder = knead, folder

    def path(self, name):
        return os.path.join(self.folder, name)

    def __call__(self, shape, session, out, *options, expect=0):
        done = subprocess.run([self.knead, "deform", shape, session, "-q", "-o", self.path(out), *options],
                              capture_output=True, text=True)
        if done.returncode != expect:
            raise AssertionError("exit %d, expected %d: %s" % (done.returncode, expect, done.stderr.strip()))
        return done.stderr if expect else read_ply(self.path(out))[0]


def worst(a, b, diagonal):
    gap = np.sqrt(((a.astype(float) - b.astype(float)) ** 2).sum(1)) / diagonal
    return gap


def check(task):
    mesh, name, events, options = task
    began = time.time()
    rng = np.random.default_rng(options["seed"])
    folder = tempfile.mkdtemp(prefix="knead-agreement-", dir=options["keep"])
    run = Run(options["knead"], folder)
    shape = os.path.join(options["meshes"], mesh + ".ply")
    points, triangles = read_ply(shape)
    diagonal = float(np.sqrt(((points.max(0).astype(float) - points.min(0)) ** 2).sum()))
    session = run.path("s.knead")
    events = write_session(session, events)
    faults, notes = [], {}

    def hold(what, value, bar):
        notes[what] = value
        if not value <= bar:
            faults.append("%s %.3g > %.3g" % (what, value, bar))

    def same(what, a, b):
        if a.tobytes() != b.tobytes():
            faults.append("%s: %d vertices differ" % (what, (a != b).any(1).sum()))

    try:
        if name.endswith("-refused"):
            message = run(shape, session, "refused.ply", expect=3)
            if message.count("\n") != 1 or os.path.exists(run.path("refused.ply")):
                faults.append("refusal is not one line, or left a file: " + message)
            numbers = re.findall(r"radius[^0-9]*([0-9][0-9.e+-]*[0-9])", message)
            notes["refused"] = message.strip()
            worked = False
            for text in numbers:
                events[0]["radius"] = float(text)
                write_session(session, events)
                try:
                    run(shape, session, "suggested.ply")
                    worked = True
                except AssertionError:
                    pass
            if not worked:
                faults.append("no suggested radius works: " + message)
            return mesh, name, faults, notes, time.time() - began

        flow = flow_of(events)
        plain = run(shape, session, "default.ply", "--threads", "1")
        exact = run(shape, session, "double.ply", "--threads", "1", "--precision", "double", "--tolerance", "1e-10")
        other = run(shape, session, "other.ply", "--precision", "double", "--tolerance", "1e-10",
                    "--integrator", "tsit5")
        assert exact.dtype == np.dtype("<f8") and plain.dtype == np.dtype("<f4")
        gap_plain, gap_exact = worst(plain, exact, diagonal), worst(exact, other, diagonal)
        moved = np.flatnonzero((exact != points).any(1))
        notes["moved"] = len(moved)
        if len(moved) < 50:
            faults.append("only %d vertices move: the case is too weak" % len(moved))
        third = options["samples"] // 3
        sample = np.unique(np.concatenate([
            np.argsort(-gap_plain)[:third], np.argsort(-gap_exact)[:third],
            rng.choice(moved, min(len(moved), options["samples"] - 2 * third), replace=False)]))
        error, truth = agreement(flow, points[sample], exact[sample], diagonal, DOUBLE_BAR)
        hold("double", error, DOUBLE_BAR)
        hold("default", worst(plain[sample], truth, diagonal).max(), DEFAULT_BAR)
        hold("default-all", gap_plain.max(), DEFAULT_BAR)
        hold("double-all", gap_exact.max(), DOUBLE_BAR)

        outside = surely_outside(flow, points.astype(float))
        notes["outside"] = int(outside.sum())
        same("outside, default", plain[outside], points[outside])
        same("outside, double", exact[outside], points[outside].astype("<f8"))

        back = run(run.path("default.ply"), session, "back.ply", "--inverse")
        hold("inverse", worst(back, points, diagonal).max(), DEFAULT_BAR)
        back = run(run.path("double.ply"), session, "back.ply", "--inverse", "--precision", "double",
                   "--tolerance", "1e-10")
        hold("inverse double", worst(back, points, diagonal).max(), DOUBLE_BAR)

        with open(run.path("default.ply"), "rb") as file:
            first = file.read()
        for threads in ("2", "1"):
            run(shape, session, "again.ply", "--threads", threads)
            with open(run.path("again.ply"), "rb") as file:
                if file.read() != first:
                    faults.append("another file with --threads " + threads)
        order = rng.permutation(len(points))
        place = np.empty_like(order)
        place[order] = np.arange(len(order))
        write_ply(run.path("permuted.ply"), points[order], place[triangles][rng.permutation(len(triangles))])
        same("permuted", run(run.path("permuted.ply"), session, "p.ply", "--threads", "2"), plain[order])
        same("permuted, double", run(run.path("permuted.ply"), session, "p.ply", "--threads", "2", "--precision",
                                     "double", "--tolerance", "1e-10"), exact[order])

        strokes = len([e for e in events if "tool" in e]) if name != "session" else 3
        until = 0.5 + (strokes - 1)
        part = run(shape, session, "until.ply", "--until", repr(until), "--precision", "double", "--tolerance", "1e-10")
        few = sample[:: max(1, len(sample) // 30)]
        hold("until", agreement(flow_of(events, until), points[few], part[few], diagonal, DOUBLE_BAR)[0], DOUBLE_BAR)

        if name in ("session", "implicit-swept"):
            subprocess.run([run.knead, "deform", shape, session, "-q", "--frames", "5", "-o", run.path("F_%04d.ply")],
                           check=True)
            frames = sorted(f for f in os.listdir(folder) if f.startswith("F_"))
            if len(frames) != 5:
                faults.append("frames: " + " ".join(frames))
            else:
                same("first frame", read_ply(run.path(frames[0]))[0], points)
                same("last frame", read_ply(run.path(frames[4]))[0], plain)
                half = run(shape, session, "half.ply", "--until", repr(strokes / 2))
                hold("middle frame", worst(read_ply(run.path(frames[2]))[0], half, diagonal).max(), DEFAULT_BAR)
    except AssertionError as error:
        faults.append(str(error))
    except Exception as error:  # a broken output is a fault of the case, not the end of the run
        faults.append(repr(error))
    finally:
        if not options["keep"]:
            shutil.rmtree(folder)
    return mesh, name, faults, notes, time.time() - began


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("knead")
    parser.add_argument("meshes")
    parser.add_argument("--samples", type=int, default=60)
    parser.add_argument("--mesh", action="append")
    parser.add_argument("--case", action="append")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--keep", help="keep the sessions and outputs in this folder")
    given = parser.parse_args()
    if given.keep:
        os.makedirs(given.keep, exist_ok=True)
    options = {"knead": os.path.abspath(given.knead), "meshes": given.meshes, "samples": given.samples,
               "seed": given.seed, "keep": given.keep}
    tasks = []
    for mesh in given.mesh or MESHES:
        points, triangles = read_ply(os.path.join(given.meshes, mesh + ".ply"))
        points = points.astype(float)
        diagonal = float(np.sqrt(((points.max(0) - points.min(0)) ** 2).sum()))
        rng = np.random.default_rng([given.seed, len(points)])
        for name, events in cases(points, triangles, diagonal, rng).items():
            if not given.case or name in given.case:
                tasks.append((mesh, name, events, options))
    if given.case is None:
        for tool in ("bend", "twist"):
            if not any(name == "limb-%s-refused" % tool for _, name, _, _ in tasks):
                print("no limb was found for", tool)
    bad = 0
    with multiprocessing.Pool(given.jobs) as pool:
        for mesh, name, faults, notes, seconds in pool.imap_unordered(check, tasks):
            bad += bool(faults)
            text = "  ".join("%s %.2g" % (k, v) if isinstance(v, float) else "%s %s" % (k, v)
                             for k, v in notes.items())
            print("%-4s %s %s (%.0f s)  %s" % ("BAD" if faults else "ok", mesh, name, seconds, text), flush=True)
            for fault in faults:
                print("     " + fault, flush=True)
    print("%d cases, %d bad" % (len(tasks), bad))
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())

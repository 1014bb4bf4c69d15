#!/usr/bin/python3
"""Writes the icons of the tools in Blender's format of triangles:  icons.py FOLDER

Each icon is a list of parts in a square from -1 to 1, y downwards, as in Studio (apps/studio/gestures/tools.cpp).
"""

import math
import os
import struct
import sys

_WIDTH = 0.16
_WHITE, _BLUE, _FAINT = (230, 230, 230, 255), (90, 170, 255, 255), (90, 170, 255, 90)

_PARTS = {
    "move": [
        ("wave", (-1, 0.8, -0.2, 0.8, -0.35, -0.1, 0, -0.1), _BLUE),
        ("wave", (0, -0.1, 0.35, -0.1, 0.2, 0.8, 1, 0.8), _BLUE),
        ("arrow", (0, 0.5, 0, -0.95), _WHITE),
    ],
    "snakehook": [("wave", (-1, 0.8, -0.1, 0.8, -0.5, -0.5, 0.75, -0.85), _BLUE), ("wave", (0.75, -0.85, 0.15, -0.3, 0.1, 0.8, 1, 0.8), _BLUE)],
    "crease": [
        ("wave", (-1, 0.05, -0.4, 0.05, -0.1, 0.1, 0, 0.9), _BLUE),
        ("wave", (0, 0.9, 0.1, 0.1, 0.4, 0.05, 1, 0.05), _BLUE),
        ("arrow", (-0.95, -0.5, -0.3, -0.5), _WHITE),
        ("arrow", (0.95, -0.5, 0.3, -0.5), _WHITE),
    ],
    "pinch": [
        ("wave", (-1, 0.75, -0.3, 0.75, -0.08, 0.4, 0, -0.35), _BLUE),
        ("wave", (0, -0.35, 0.08, 0.4, 0.3, 0.75, 1, 0.75), _BLUE),
        ("arrow", (-0.95, 0.1, -0.35, 0.1), _WHITE),
        ("arrow", (0.95, 0.1, 0.35, 0.1), _WHITE),
    ],
    "flatten": [("line", (-1, 0.5, 1, 0.5), _BLUE), ("arc", (0, 0.5, 0.5, -math.pi, 0), _BLUE), ("arrow", (0, -0.95, 0, -0.15), _WHITE)],
    "pull": [("disc", (-0.2, 0.2, 0.75), _FAINT), ("circle", (-0.2, 0.2, 0.42), _BLUE), ("arrow", (-0.2, 0.2, 0.85, -0.85), _WHITE)],
    "paint": [
        ("wave", (-1, 0.8, -0.3, 0.8, -0.5, 0.1, 0, 0.1), _BLUE),
        ("wave", (0, 0.1, 0.5, 0.1, 0.3, 0.8, 1, 0.8), _BLUE),
        ("line", (0.1, -0.25, 0.7, -0.95), _WHITE),
        ("disc", (0.03, -0.17, 0.2), _WHITE),
    ],
    "rotate": [("disc", (0, 0, 0.16), _BLUE), ("arc", (0, 0, 0.75, -0.3 * math.pi, 1.3 * math.pi), _WHITE), ("arrow", (0.2, -0.72, 0.46, -0.6), _WHITE)],
    "stretch": [("box", (-0.3, -0.3, 0.3, 0.3), _BLUE), ("arrow", (0.45, 0, 0.98, 0), _WHITE), ("arrow", (-0.45, 0, -0.98, 0), _WHITE)],
    "twist": [
        ("wave", (-0.5, 0.95, -0.5, 0.1, 0.5, -0.1, 0.5, -0.95), _BLUE),
        ("wave", (0.5, 0.95, 0.5, 0.1, -0.5, -0.1, -0.5, -0.95), _BLUE),
        ("line", (-0.5, 0.95, 0.5, 0.95), _WHITE),
        ("line", (-0.5, -0.95, 0.5, -0.95), _WHITE),
    ],
    "bend": [
        ("wave", (-0.7, 0.95, -0.7, -0.1, -0.4, -0.75, 0.5, -0.85), _BLUE),
        ("wave", (-0.05, 0.95, -0.05, 0.3, 0.1, -0.1, 0.75, -0.25), _BLUE),
        ("line", (0.5, -0.85, 0.75, -0.25), _WHITE),
        ("line", (-0.7, 0.95, -0.05, 0.95), _WHITE),
    ],
    "stamp": [
        ("box", (-0.35, -0.9, 0.35, 0), _WHITE),
        ("wave", (-1, 0.2, -0.4, 0.2, -0.7, 0.8, 0, 0.8), _BLUE),
        ("wave", (0, 0.8, 0.7, 0.8, 0.4, 0.2, 1, 0.2), _BLUE),
    ],
    "pose": [
        ("line", (-0.6, 0.85, -0.5, 0), _BLUE),
        ("line", (-0.5, 0, 0.4, -0.3), _BLUE),
        ("disc", (-0.6, 0.8, 0.2), _WHITE),
        ("disc", (-0.5, 0, 0.2), _WHITE),
        ("arrow", (0.4, -0.3, 0.9, -0.9), _WHITE),
    ],
}


def _line(points):
    triangles = []
    for (x0, y0), (x1, y1) in zip(points, points[1:]):
        length = math.hypot(x1 - x0, y1 - y0) or 1
        u, v = -(y1 - y0) / length * _WIDTH / 2, (x1 - x0) / length * _WIDTH / 2
        a, b, c, d = (x0 + u, y0 + v), (x0 - u, y0 - v), (x1 - u, y1 - v), (x1 + u, y1 + v)
        triangles += [(a, b, c), (a, c, d)]
    return triangles


def _arc(x, y, r, first, last):
    return [(x + r * math.cos(t), y + r * math.sin(t)) for t in (first + (last - first) * i / 20 for i in range(21))]


def _bezier(n):
    result = []
    for i in range(15):
        t = i / 14
        w = ((1 - t) ** 3, 3 * t * (1 - t) ** 2, 3 * t * t * (1 - t), t**3)
        result.append((sum(w[k] * n[2 * k] for k in range(4)), sum(w[k] * n[2 * k + 1] for k in range(4))))
    return result


def _arrow(x0, y0, x1, y1):
    angle = math.atan2(y1 - y0, x1 - x0)
    tip = [(x1 - 0.45 * math.cos(angle + s), y1 - 0.45 * math.sin(angle + s)) for s in (-0.6, 0.6)]
    return [*_line([(x0, y0), (x1, y1)]), ((x1, y1), *tip)]


def _triangles(kind, n):
    if kind == "line":
        return _line([n[:2], n[2:]])
    if kind == "arrow":
        return _arrow(*n)
    if kind == "box":
        return _line([(n[0], n[1]), (n[2], n[1]), (n[2], n[3]), (n[0], n[3]), (n[0], n[1])])
    if kind == "wave":
        return _line(_bezier(n))
    if kind == "arc":
        return _line(_arc(*n))
    rim = _arc(*n, 0, 2 * math.pi)
    return _line(rim) if kind == "circle" else [((n[0], n[1]), a, b) for a, b in zip(rim, rim[1:])]


def icon(parts):
    """Returns the bytes of an icon file: corners of triangles, then a colour for each."""
    corners, colors = b"", b""
    for kind, numbers, color in parts:
        for triangle in _triangles(kind, numbers):
            for x, y in triangle:
                corners += bytes(min(max(round(127.5 + sign * 115 * v), 0), 255) for sign, v in ((1, x), (-1, y)))
                colors += bytes(color)
    return b"VCO\0" + struct.pack("4B", 255, 255, 0, 0) + corners + colors


def main(folder):
    os.makedirs(folder, exist_ok=True)
    for name, parts in _PARTS.items():
        with open(os.path.join(folder, name + ".dat"), "wb") as file:
            file.write(icon(parts))


if __name__ == "__main__":
    main(sys.argv[1])

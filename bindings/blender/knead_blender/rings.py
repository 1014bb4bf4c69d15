# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws the regions of a tool as rings on the surface."""

import gpu
import numpy as np
from gpu_extras.batch import batch_for_shader

_OUTER, _INNER = (0.2, 0.65, 1.0, 0.9), (1.0, 0.55, 0.15, 0.9)


def of(surface, point, normal, radii):
    """Returns a ring of places on the surface for each radius."""
    return [surface.ring(point, normal, radius, 48) for radius in radii]


def flat(point, normal, radii):
    """Returns flat rings, where no surface is at hand."""
    normal = np.asarray(normal, np.float64)
    u = np.cross(normal, np.eye(3)[np.abs(normal).argmin()])
    u /= np.linalg.norm(u)
    v = np.cross(normal, u)
    turn = np.linspace(0, 2 * np.pi, 48, endpoint=False)[:, None]
    return [np.asarray(point) + radius * (np.cos(turn) * u + np.sin(turn) * v) for radius in radii]


def draw(view, rings):
    """Draws rings in the pixels of the region: the outer one first."""
    shader = gpu.shader.from_builtin("POLYLINE_UNIFORM_COLOR")
    gpu.state.blend_set("ALPHA")
    for ring, color in zip(rings, (_OUTER, _INNER)):
        pixels = view.pixels(ring)
        if len(pixels) < 3 or not np.isfinite(pixels).all():
            continue
        closed = [(x, y, 0.0) for x, y in np.vstack([pixels, pixels[:1]])]
        shader.uniform_float("viewportSize", (view.region.width, view.region.height))
        shader.uniform_float("lineWidth", 2.0)
        shader.uniform_float("color", color)
        batch_for_shader(shader, "LINE_STRIP", {"pos": closed}).draw(shader)
    gpu.state.blend_set("NONE")


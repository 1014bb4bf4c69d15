# SPDX-License-Identifier: GPL-3.0-or-later
"""knead.check: volume, crossings and angles, in the panel."""

import bpy
import numpy as np
from bpy.props import BoolProperty

from . import compat, shape, shown, state
from .native import knead
from .operators import Plain


def _triangles(mesh):
    mesh.calc_loop_triangles()
    triangles = np.empty(3 * len(mesh.loop_triangles), np.int32)
    mesh.loop_triangles.foreach_get("vertices", triangles)
    return triangles.reshape(-1, 3)


def _crossing_faces(mesh, coordinates, triangles):
    """Returns the polygons that cross others."""
    polygons = np.empty(len(triangles), np.int32)
    mesh.loop_triangles.foreach_get("polygon_index", polygons)
    return np.unique(polygons[knead.crossings(coordinates, triangles).ravel()])


class KNEAD_OT_check(Plain, bpy.types.Operator):
    """Measure volume, crossings and the smallest angle of the mesh as it is shown; select what crosses"""

    bl_idname = "knead.check"
    bl_label = "Check"
    select: BoolProperty(name="Select What Crosses", default=True)

    def work(self, context, obj):
        mesh = obj.data
        if len(mesh.polygons) == 0:
            raise state.Refusal("The mesh has no faces to check")
        coordinates = shown.read(obj).astype(np.float64)
        triangles = _triangles(mesh)
        now = knead.check(coordinates, triangles)
        base = shape.read_base(mesh)
        before = knead.check((shape.read(obj) if base is None else base).astype(np.float64), triangles)
        obj.knead.report = "\n".join(_lines(before, now))
        if self.select:
            chosen = np.zeros(len(mesh.polygons), bool)
            if now["self_intersections"]:
                chosen[_crossing_faces(mesh, coordinates, triangles)] = True
            _select(mesh, chosen)


def _lines(before, now):
    lines = []
    if now.get("closed"):
        lines.append(f"Volume: {now['volume']:.9g}, before {before['volume']:.9g}")
        if before["volume"]:
            lines.append(f"Change of volume: {100 * (now['volume'] / before['volume'] - 1):.3g} %")
    else:
        lines.append("The surface is open: it has no volume")
    lines.append(f"Smallest angle: {now['smallest_angle_deg']:.3g} degrees")
    lines.append(f"Crossings: {now['self_intersections']}, before {before['self_intersections']}")
    return lines


def _select(mesh, chosen):
    corners = np.empty(len(mesh.loops), np.int32)
    mesh.loops.foreach_get("vertex_index", corners)
    totals = np.empty(len(mesh.polygons), np.int32)
    mesh.polygons.foreach_get("loop_total", totals)
    vertices = np.zeros(len(mesh.vertices), bool)
    vertices[corners[np.repeat(chosen, totals)]] = True
    compat.select(mesh, vertices, chosen)
    mesh.update()


def register():
    bpy.utils.register_class(KNEAD_OT_check)


def unregister():
    bpy.utils.unregister_class(KNEAD_OT_check)

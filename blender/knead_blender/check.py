"""knead.check: volume, crossings and angles, in the panel."""

import bpy
import numpy as np
from bpy.props import BoolProperty

from . import shape, state
from .native import knead
from .operators import Plain


def _triangles(mesh):
    mesh.calc_loop_triangles()
    triangles = np.empty(3 * len(mesh.loop_triangles), np.int32)
    mesh.loop_triangles.foreach_get("vertices", triangles)
    return triangles.reshape(-1, 3)


def _crossing_faces(mesh, coordinates, triangles):
    """Returns the polygons whose triangles overlap others that share no vertex with them, by Blender's search tree."""
    from mathutils.bvhtree import BVHTree

    tree = BVHTree.FromPolygons(coordinates.tolist(), triangles.tolist(), all_triangles=True)
    pairs = np.array(tree.overlap(tree), np.int64).reshape(-1, 2)
    pairs = pairs[pairs[:, 0] < pairs[:, 1]]
    first, second = triangles[pairs[:, 0]], triangles[pairs[:, 1]]
    apart = (first[:, :, None] != second[:, None, :]).all(axis=(1, 2))
    polygons = np.empty(len(triangles), np.int32)
    mesh.loop_triangles.foreach_get("polygon_index", polygons)
    return np.unique(polygons[pairs[apart].ravel()])


class KNEAD_OT_check(Plain, bpy.types.Operator):
    """Measure volume, crossings and the smallest angle of the mesh; select what crosses"""

    bl_idname = "knead.check"
    bl_label = "Check"
    select: BoolProperty(name="Select What Crosses", default=True)

    def work(self, context, obj):
        mesh = obj.data
        if len(mesh.polygons) == 0:
            raise state.Refusal("The mesh has no faces to check")
        coordinates = shape.read(obj).astype(np.float64)
        triangles = _triangles(mesh)
        now = knead.check(coordinates, triangles)
        base = shape.read_base(mesh)
        before = now if base is None else knead.check(base.astype(np.float64), triangles)
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
    vertices = np.zeros(len(mesh.vertices), bool)
    edges = np.zeros(len(mesh.edges), bool)
    for polygon in np.flatnonzero(chosen):
        vertices[list(mesh.polygons[polygon].vertices)] = True
    mesh.vertices.foreach_set("select", vertices)
    mesh.edges.foreach_set("select", edges)
    mesh.polygons.foreach_set("select", chosen)
    mesh.update()


def register():
    bpy.utils.register_class(KNEAD_OT_check)


def unregister():
    bpy.utils.unregister_class(KNEAD_OT_check)

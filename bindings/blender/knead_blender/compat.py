# SPDX-License-Identifier: GPL-3.0-or-later
"""Everything that differs between Blender 3.4 and later ones."""

import bpy
import numpy as np


def sculpt_mask(mesh):
    """Returns the data of the sculpt mask, each with .value, or None. Since 4.1 it is a named attribute."""
    attribute = mesh.attributes.get(".sculpt_mask")
    if attribute is not None:
        return attribute.data
    layers = getattr(mesh, "vertex_paint_masks", None)
    return layers[0].data if layers else None


def curves(data):
    """Returns the animation curves of a data-block. Since 4.4 they lie in layers of an action."""
    animation = data.animation_data
    if hasattr(animation.action, "fcurves"):
        return list(animation.action.fcurves)
    strips = (strip for layer in animation.action.layers for strip in layer.strips)
    bags = (strip.channelbag(animation.action_slot) for strip in strips)
    return [curve for bag in bags if bag is not None for curve in bag.fcurves]


def select(mesh, vertices, polygons):
    """Selects vertices and polygons, given as arrays of bool, and no edge.

    Since 4.0 the selection is attributes; 5.0.1 ends in a crash where it is set in the older way."""
    if bpy.app.version < (4, 0):
        edges = np.zeros(len(mesh.edges), bool)
        for each, values in ((mesh.vertices, vertices), (mesh.edges, edges), (mesh.polygons, polygons)):
            each.foreach_set("select", values)
        return
    edges = mesh.attributes.get(".select_edge")
    if edges is not None:
        mesh.attributes.remove(edges)
    for name, domain, values in ((".select_vert", "POINT", vertices), (".select_poly", "FACE", polygons)):
        attribute = mesh.attributes.get(name) or mesh.attributes.new(name, "BOOLEAN", domain)
        attribute.data.foreach_set("value", values)


def sculpt_tool():
    """Returns the name of a tool of sculpt mode that is always there."""
    return "builtin_brush.Draw" if bpy.app.version < (4, 3) else "builtin.brush"

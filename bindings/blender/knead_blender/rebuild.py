# SPDX-License-Identifier: GPL-3.0-or-later
"""Computes what a session makes of a mesh."""

import numpy as np

from . import compat, shape, state
from .native import knead


def check_session(session):
    """Raises Refusal for sessions that Blender's mesh cannot follow."""
    if '\n{"remesh"' in session.text():
        raise state.Refusal("The session remeshes; Blender's mesh keeps its vertices, so use the command knead deform")


def compute(base, faces, session, frame, relative_tolerance=1e-5, progress=None):
    """Returns the float32 coordinates that the session gives for the base ones; None if `progress` ended it."""
    check_session(session)
    entered = frame.enter(base)
    moved = knead.deform(entered, session, faces, relative_tolerance=relative_tolerance, progress=progress)
    return None if moved is None else frame.leave(moved, entered, base)


def mask_stroke(obj, width, group=None):
    """Returns the mask that a vertex group, else the sculpt mask, describes: an event for the session.

    Hidden vertices are locked as well. `width` is how far from what stays the mesh is free again.
    """
    values = np.zeros(len(obj.data.vertices), np.float32)
    if group is not None:
        for vertex in obj.data.vertices:
            for entry in vertex.groups:
                if entry.group == group.index:
                    values[vertex.index] = entry.weight
    else:
        data = compat.sculpt_mask(obj.data)
        if data is not None:
            data.foreach_get("value", values)
    hidden = np.empty(len(values), bool)
    obj.data.vertices.foreach_get("hide", hidden)
    values[hidden] = 1
    kept = np.flatnonzero(values > 0)
    if len(kept) == 0:
        raise state.Refusal("Nothing is masked; paint a sculpt mask, or name a vertex group with weights")
    return knead.Mask(vertices=kept.tolist(), values=np.clip(values[kept], 0, 1).astype(float).tolist(), width=width)

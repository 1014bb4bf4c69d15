"""Knead deforms 3D shapes by divergence-free vector fields.

Volume stays, nothing passes through itself, details survive, and whatever is outside a tool does not move at all.

    import knead

    shape = knead.read("scan.ply")
    session = knead.Session([knead.Implicit(path=[[0, 1, 0], [0, 1.4, 0]], inner=0.1, outer=0.5)])
    shape.vertices = knead.deform(shape.vertices, session)
    shape.write("out.ply")

Lengths are in the shape's units, angles in degrees. help(knead.deform) says how shapes, units and errors are given.
"""

from . import _strokes
from ._deform import Flow, Remeshed, Workbench, animate, certify, deform, frames, remesh, render, write_frames
from ._fit import Fit, fit
from ._gesture import PaintDrag, Surface, brush, symmetric
from ._knead import AccuracyError, FileError, InvalidInput, Unavailable, __version__
from ._lattice import lattice_points
from ._mean import Population, mean
from ._measures import Measure, area_of, curvature, patch_distance, thickness_at, volume_of
from ._meshes import deform_cells, deform_mesh, from_build123d, safe_until, widest_outer
from ._session import Session
from ._skin import Corrective, Posed, correctives, skin
from ._shapes import Shape, check, check_cells, crossings, read, write
from ._splats import Splats
from ._strokes import Stroke, stroke

globals().update({cls.__name__: cls for cls in _strokes._classes.values()})

for _name in ("AccuracyError", "FileError", "InvalidInput", "Unavailable"):
    globals()[_name].__module__ = "knead"

__all__ = [
    "AccuracyError",
    "Corrective",
    "FileError",
    "Fit",
    "Flow",
    "InvalidInput",
    "Measure",
    "PaintDrag",
    "Population",
    "Posed",
    "Remeshed",
    "Session",
    "Shape",
    "Splats",
    "Stroke",
    "Surface",
    "Unavailable",
    "Workbench",
    "animate",
    "area_of",
    "brush",
    "certify",
    "check",
    "check_cells",
    "correctives",
    "crossings",
    "curvature",
    "deform",
    "deform_cells",
    "deform_mesh",
    "fit",
    "frames",
    "from_build123d",
    "lattice_points",
    "mean",
    "patch_distance",
    "read",
    "remesh",
    "render",
    "safe_until",
    "skin",
    "stroke",
    "symmetric",
    "thickness_at",
    "volume_of",
    "widest_outer",
    "write",
    "write_frames",
    *(cls.__name__ for cls in _strokes._classes.values()),
]

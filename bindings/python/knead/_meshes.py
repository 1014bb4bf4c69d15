"""Meshes of other packages, none of which is needed here."""

import copy

from . import _knead
from ._arrays import faces_for
from ._deform import _accuracy, deform
from ._knead import InvalidInput
from ._session import native_session
from ._shapes import Shape, cell_blocks, solid_blocks, volume_cells
from ._splats import Splats, deform_arrays, deform_shape


def deform_cells(
    points,
    cells,
    session,
    *,
    least_scaled_jacobian=0.05,
    fixed=None,
    relative_tolerance=1e-5,
    precision="float64",
    integrator="tsit5",
    threads=0,
    until=None,
    diagonal=None,
    progress=None,
):
    """Returns the points of a volume mesh deformed so that its cells stay good, and a report.

    Points on the boundary, fixed points and points outside all tools go exactly where deform() takes them. An interior
    point next to a cell that falls below `least_scaled_jacobian` (above 0, at most 0.5) climbs to where the least scaled
    Jacobian around it is greater. Of cells that were below it before only inverted ones count. If that is not enough, the
    motion is made in 8 or 32 parts, and points climb after each.

    precision: "float64" by default: thin cells need it. points, cells: as for check_cells. Corners of triangles and quadrilaterals of a meshio mesh are fixed.
    fixed: a boolean for each point, or None.
    The other options are those of deform; the session must not read a surface (see Session.resolve).

    The report is a dict: "flow" for the deformation alone and "result", each with "inverted" (cells),
    "below" (cells that fell below the bound), "least_scaled_jacobian" and "mean_volume_change" (the mean of |volume ratio - 1|); "freed", the number of points that
    left the flow; and "parts". A bound that was not reached is no error: read the report. Returns (None, None) if
    `progress` returned False. Raises as deform and check_cells.
    """
    import numpy as np

    blocks = solid_blocks(points, cells)
    count = len(getattr(points, "vertices", getattr(points, "points", points)))
    mask = np.zeros(count, np.uint8)
    if fixed is not None:
        if np.shape(fixed) != (count,):
            raise InvalidInput(f"fixed must have shape ({count},), got {np.shape(fixed)}")
        mask[:] = np.asarray(fixed, bool)
    for block in cells if isinstance(cells, (list, tuple)) else ():
        if getattr(block, "type", "").rstrip("0123456789") in ("triangle", "quad"):
            corners = np.asarray(block.data).ravel()
            if len(corners) and not 0 <= corners.min() <= corners.max() < count:
                raise InvalidInput(f"a face of the mesh has a corner that is not among the {count} points")
            mask[corners] = 1
    accuracy = _accuracy(relative_tolerance, precision, integrator, threads, diagonal)
    how = (until, least_scaled_jacobian, mask)
    return _knead.deform_cells(points, blocks, native_session(session), accuracy, how, progress) or (None, None)


def safe_until(
    points,
    cells,
    session,
    *,
    least_scaled_jacobian=0,
    inverse=False,
    relative_tolerance=1e-5,
    precision="float64",
    integrator="tsit5",
    threads=0,
    until=None,
    diagonal=None,
    progress=None,
):
    """Returns how far a session can be applied to a volume mesh before it spoils a cell, as a dict.

    A cell is spoiled if it is inverted, exactly, or if its scaled Jacobian falls below `least_scaled_jacobian` (0 or more,
    below 1). Cells that were below it before, or flat, do not count.

    points, cells: as for check_cells. The other options are those of deform; `until` is the most that is tried.

    "until": the number of strokes, for deform(until=...), with which no cell is spoiled. "beyond": the least number at
    which one was found to be; equal to "until" if the whole session is safe. "cell": the worst cell there, and
    "scaled_jacobian" of it, or None. "outer": for the stroke that spoils it, the value of widest_outer, or None.

    Every 16th of a stroke is looked at in order (of more than 16 strokes every 256th of the whole), then the range before
    the first one that spoils a cell is bisected. A cell that is spoiled and recovers in between is not seen. Returns None
    if `progress` returned False. Raises as deform and check_cells.
    """
    accuracy = _accuracy(relative_tolerance, precision, integrator, threads, diagonal)
    how = (bool(inverse), until, least_scaled_jacobian)
    return _knead.safe_until(points, solid_blocks(points, cells), native_session(session), accuracy, how, progress)


def widest_outer(points, cells, stroke):
    """Returns the greatest `outer` with which a stroke moves no point of the boundary that it leaves at rest, or None.

    A wider transition strains the cells of a volume mesh less. Three digits; for Implicit, Points, Rotate and Stretch.
    None for other strokes, where all of the boundary moves, and where less than 5% can be gained. `points` are those
    before the stroke. points, cells: as for check_cells.
    """
    return _knead.widest_outer(points, cell_blocks(cells), native_session(stroke))


def deform_mesh(mesh, session, *, least_scaled_jacobian=None, report=None, **options):
    """Returns a mesh of the same kind with its vertices deformed; the given one stays as it is.

    mesh: of trimesh, meshio, open3d or pyvista, or anything with .vertices and .faces, .points and .cells, or .points and
    .faces. options: those of deform, but `faces` and `out`. Stored normals of a surface are computed anew. Of Splats, and
    of a Shape that holds splats, also sizes, turns and colours change; long splats are split, so that there are more of them
    after it: at most `max_splats` (an option; by default twice as many, 0: none are split).
    least_scaled_jacobian: for a volume mesh of meshio, interior points move until its cells reach it where they can, as
    deform_cells says. report: a dict that receives the report of deform_cells.
    """
    import numpy as np

    if isinstance(mesh, Splats):
        return deform_arrays(mesh, session, **options)
    if isinstance(mesh, Shape) and mesh._native.holds_splats():
        return deform_shape(mesh, session, **options)
    faces = faces_for(mesh)
    if hasattr(mesh, "cast_to_structured_grid"):  # pyvista's images and rectilinear grids, whose points follow from a rule
        mesh = mesh.cast_to_structured_grid()
    name = next((n for n in ("vertices", "points") if hasattr(mesh, n)), None)
    if name is None:
        raise TypeError(f"deform_mesh needs an object with .vertices or .points, got a {type(mesh).__name__}")
    package = type(mesh).__module__.split(".")[0]
    given = np.asarray(getattr(mesh, name))
    if least_scaled_jacobian is None:
        cells = volume_cells(mesh)
        if cell_blocks(cells):
            options = {"precision": "float64", "cells": cells, **options}
        moved = deform(mesh if isinstance(mesh, Shape) else _in_space(given), session, faces, **options)
    else:
        cells = getattr(mesh, "cells", None)
        if not isinstance(cells, (list, tuple)) or not cell_blocks(cells):
            raise InvalidInput("least_scaled_jacobian needs a mesh with volume cells, as meshio reads them")
        moved, found = deform_cells(given, cells, session, least_scaled_jacobian=least_scaled_jacobian, **options)
        if report is not None and found is not None:
            report.update(found)
    if moved is None:
        return None
    if package == "open3d":
        return _open3d(mesh, name, moved)
    if isinstance(mesh, Shape):
        result = copy.copy(mesh)
    else:
        result = mesh.copy() if hasattr(mesh, "copy") else copy.deepcopy(mesh)
    setattr(result, name, moved.astype(given.dtype, copy=False) if given.dtype.kind == "f" else moved)
    if package == "pyvista" and hasattr(result, "compute_normals"):
        _pyvista_normals(result)
    return result


def from_build123d(part, tolerance=None):
    """Returns a part of build123d or CadQuery as a Shape of triangles.

    tolerance: how far the triangles may be from the part, in its unit, above 0; None: 1e-4 of the diagonal of its box. A
    CadQuery Workplane gives all solids that it holds. Equal places of different faces are one vertex, so that a solid is closed.
    """
    import numpy as np

    part = getattr(part, "part", part)  # of a BuildPart
    pieces = part.vals() if hasattr(part, "vals") else [part]
    if not pieces or not all(hasattr(piece, "tessellate") for piece in pieces):
        raise TypeError(f"from_build123d needs a part of build123d or CadQuery, got a {type(part).__name__}")

    if tolerance is None:
        box = pieces[0].bounding_box() if hasattr(pieces[0], "bounding_box") else pieces[0].BoundingBox()
        tolerance = 1e-4 * getattr(box, "diagonal", getattr(box, "DiagonalLength", 1))
    if not tolerance > 0:
        raise InvalidInput(f"tolerance must be a length above 0, got {tolerance:g}")
    vertices, faces = [], []
    for piece in pieces:
        places, corners = piece.tessellate(tolerance)
        faces += [[len(vertices) + corner for corner in face] for face in corners]
        vertices += [tuple(place) if hasattr(place, "__iter__") else place.toTuple() for place in places]
    vertices, number = np.unique(np.array(vertices, float), axis=0, return_inverse=True)
    faces = number.ravel()[np.array(faces, int)]
    return Shape(vertices, faces[(faces != np.roll(faces, 1, axis=1)).all(axis=1)])  # none that became a line


def _in_space(points):
    """Raises a sentence for the points of a plane mesh."""
    if points.ndim == 2 and points.shape[1] == 2:
        raise InvalidInput(f"the points have shape {points.shape}; append a third column of zeros to a plane mesh")
    return points


def _pyvista_normals(mesh):
    # compute_normals() keeps those that are stored
    stored = [data.pop("Normals", None) is not None for data in (mesh.point_data, mesh.cell_data)]
    if any(stored):
        kinds = {"point_normals": stored[0], "cell_normals": stored[1]}
        mesh.compute_normals(**kinds, split_vertices=False, consistent_normals=False, inplace=True)


def _open3d(mesh, name, moved):
    import numpy as np
    import open3d

    result = copy.copy(mesh)
    setattr(result, name, open3d.utility.Vector3dVector(np.asarray(moved, dtype=np.float64)))
    if hasattr(result, "has_triangle_normals") and result.has_triangle_normals():
        result.compute_triangle_normals()
    if hasattr(result, "has_vertex_normals") and result.has_vertex_normals():
        result.compute_vertex_normals()
    return result

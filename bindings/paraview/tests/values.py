"""The filter moves points as the command and the library do, bit-identical, and its arrays say what they should."""

import numpy as np
from support import *  # noqa: F403
from vtkmodules.vtkCommonCore import vtkDoubleArray


def check_points(name, **properties):
    """Every point of the result is where the library takes it; returns the data sets."""
    source = opened(name)
    result = deformed(source, "move", **properties)
    sets = [data for data in leaves(result) if data.GetNumberOfPoints()]
    require(sets, f"{name}: nothing came out")
    session = knead.Session.read(session_file("move"))
    diagonal = diagonal_of(source)
    for data in sets + ([cloud_of(result)] if name.endswith(".vtu") else []):
        expected = knead.deform(start_of(data), session, diagonal=diagonal, inverse=bool(properties.get("Inverse", 0)),
                                until=properties.get("Until"), precision="float64")
        require(np.array_equal(points_of(data), expected), f"{name} {properties}: other points than the library's")
        require(not np.array_equal(expected, start_of(data)), f"{name}: nothing moved")
    return sets


def test_polydata_has_the_bits_of_the_command():
    source = simple.PLYReader(FileNames=[path_of("torus.ply")])
    start = points_of(leaves(source)[0])
    expected = points_of(leaves(simple.PLYReader(FileNames=[path_of("moved.ply")]))[0])
    if RANKS > 1:
        source = simple.XMLPartitionedPolydataReader(FileName=[path_of("torus.pvtp")])
    before = np.vstack([points_of(data) for data in leaves(source)])
    after = np.vstack([points_of(data) for data in leaves(deformed(source, "move"))])
    require(after.dtype == np.float32, "float points became doubles")
    known = {p.tobytes(): q.tobytes() for p, q in zip(start, expected)}
    require(len(known) == len(start), "two points of the torus are equal")
    require(len(before) >= len(start), "points are missing")
    for p, q in zip(before, after):
        require(known[p.tobytes()] == q.tobytes(), f"{p} went to {q}")


def test_every_kind_of_data_set():
    for name in ["zoo.vtu", "box.vtu", "image.vti", "rectilinear.vtr", "curvilinear.vts", "blocks.vtm", "parts.vtpc"]:
        check_points(name)
    check_points("box.vtu", Until=0.4)
    check_points("box.vtu", Inverse=1)


def test_quality():
    data = check_points("zoo.vtu")[0]
    types = np.array([data.GetCellType(i) for i in range(data.GetNumberOfCells())])
    require(not np.isin(types, [8, 11]).any(), "voxels or pixels are left, though their axes are bent")
    ratio = array_of(data.GetCellData(), "KneadVolumeRatio")
    jacobian = array_of(data.GetCellData(), "KneadScaledJacobian")
    has_volume = types >= 10
    require(np.isfinite(ratio[has_volume]).all() and np.isnan(ratio[~has_volume]).all(), "volume ratios")
    # The corners of large cells follow the flow, their edges do not.
    changed = np.abs(ratio[has_volume] - 1)
    require(ratio[has_volume].min() > 0 and changed.mean() < 0.05, f"volumes changed by {changed.mean()}")
    require(np.isnan(jacobian[types == 42]).all() and (jacobian[has_volume & (types != 42)] > 0).all(), "Jacobians")

    box = check_points("box.vtu")[0]
    corners = np.array([[box.GetCell(i).GetPointId(k) for k in range(4)] for i in range(box.GetNumberOfCells())])
    expected = knead.check_cells(points_of(box), corners, before=start_of(box))
    for name, key in [("KneadVolumeRatio", "volume_ratio"), ("KneadScaledJacobian", "scaled_jacobian"),
                      ("KneadNonOrthogonality", "non_orthogonality_deg"), ("KneadSkewness", "skewness")]:
        require(np.array_equal(array_of(box.GetCellData(), name), expected[key]), f"{name} is not check_cells'")
    centers = leaves(simple.CellCenters(Input=deformed(opened("box.vtu"), "move")))[0].GetPointData()
    whole = leaves(deformed(simple.OpenDataFile(path_of("box.vtu")), "move"))[0].GetCellData()
    for name in ["KneadVolumeRatio", "KneadScaledJacobian"]:
        same = np.array_equal(np.sort(array_of(centers, name)), np.sort(array_of(whole, name)))
        require(same, f"{name} of all ranks is not that of one")
    gradient = knead.Flow(knead.Session.read(session_file("move"))).jacobian(start_of(box), diagonal=diagonal_of(opened("box.vtu")))
    stretch = array_of(box.GetPointData(), "KneadStretch")
    require(np.allclose(stretch, np.linalg.norm(gradient, 2, axis=(1, 2)), rtol=1e-12), "KneadStretch")
    require(array_of(box.GetFieldData(), "KneadInvertedCells")[0] == 0, "cells were inverted")

    plain = leaves(deformed(opened("box.vtu"), "move", Quality=0))[0]
    require(plain.GetCellData().GetArray("KneadVolumeRatio") is None, "arrays without Quality")


def test_vectors():
    source = opened("box.vtu")
    before = leaves(source)[0]
    after = leaves(deformed(source, "move", VectorsToTransform=["velocity"]))[0]
    require(np.array_equal(start_of(before), start_of(after)), "points in another order")
    gradient = knead.Flow(knead.Session.read(session_file("move"))).jacobian(start_of(before), diagonal=diagonal_of(opened("box.vtu")))
    velocity = array_of(before.GetPointData(), "velocity")
    expected = np.einsum("nij,nj->ni", gradient, velocity)
    require(np.allclose(array_of(after.GetPointData(), "velocity"), expected, rtol=1e-12, atol=1e-14), "velocities")
    untouched = leaves(deformed(source, "move"))[0]
    require(np.array_equal(array_of(untouched.GetPointData(), "velocity"), velocity), "velocities changed unasked")


def test_ghosts_agree():
    """Points of ghost cells go where the library takes them, as on the rank whose they are; the cells are not counted."""
    source = opened("box.vtu")
    ghosts = simple.GhostCellsGenerator(Input=source, BuildIfRequired=0)
    for name, properties in [("move", {}), ("invert", {"FailOnInversion": 0})]:
        result = deformed(ghosts, name, **properties)
        data = leaves(result)[0]  # the part of the first rank, with its ghosts
        hidden = 0 if data.GetCellGhostArray() is None else int((vtk_to_numpy(data.GetCellGhostArray()) & 1).sum())
        everything = result.GetDataInformation().GetNumberOfCells()
        require((hidden > 0) == (RANKS > 1) and everything >= 6 * 12**3 + hidden, f"{hidden} ghosts, {everything} cells")
        expected = knead.deform(start_of(data), knead.Session.read(session_file(name)), diagonal=diagonal_of(source),
                                precision="float64")
        require(np.array_equal(points_of(data), expected), "a ghost is not where the other rank has it")
        plain = deformed(source, name, **properties)
        counts = [int(array_of(leaves(r)[0].GetFieldData(), "KneadInvertedCells")[0]) for r in (plain, result)]
        require(counts[0] == counts[1], f"inverted cells without and with ghosts: {counts}")
        require((counts[0] > 0) == (name == "invert"), f"{name}: {counts}")


def test_precision_and_diagonal():
    session = knead.Session.read(session_file("move"))
    start = start_of(leaves(opened("box.vtu"))[0])
    seen = set()
    for properties, options in [
        ({}, {"diagonal": diagonal_of(opened("box.vtu")), "precision": "float64"}),
        ({"Precision": "float"}, {"diagonal": diagonal_of(opened("box.vtu")), "precision": "float32"}),
        ({"Diagonal": 100.0}, {"diagonal": 100.0, "precision": "float64"}),
        ({"RelativeTolerance": 1e-8},
         {"diagonal": diagonal_of(opened("box.vtu")), "relative_tolerance": 1e-8, "precision": "float64"}),
    ]:
        points = points_of(leaves(deformed(opened("box.vtu"), "move", **properties))[0])
        start = start_of(leaves(deformed(opened("box.vtu"), "move", **properties))[0])
        require(np.array_equal(points, knead.deform(start, session, **options)), f"{properties}: not the library's points")
        seen.add(points.tobytes())
    require(len(seen) == 4, "two of the settings gave the same points")


def test_normals_of_cells_are_dropped():
    """Also where they have no name."""
    if RANKS > 1:
        return  # a file cannot hold them, and an object of Python is on one rank only
    grid = leaves(opened("box.vtu"))[0]
    normals = vtkDoubleArray()
    normals.SetNumberOfComponents(3)
    normals.SetNumberOfTuples(grid.GetNumberOfCells())
    normals.Fill(1)
    grid.GetCellData().SetNormals(normals)
    source = simple.TrivialProducer()
    source.GetClientSideObject().SetOutput(grid)
    require(leaves(source)[0].GetCellData().GetNormals() is not None, "the input has no normals")
    cells = leaves(deformed(source, "move", Quality=0))[0].GetCellData()
    require(cells.GetNormals() is None, "the normals of the cells are left")


def test_time_series():
    source = simple.XMLUnstructuredGridReader(FileName=[path_of("zoo.vtu"), path_of("box.vtu")])
    result = simple.Knead(Input=source, SessionFile=session_file("move"))
    require(len(source.TimestepValues) == 2, "no series")
    for time in source.TimestepValues:
        source.UpdatePipeline(time)
        diagonal = diagonal_of(source)
        result.UpdatePipeline(time)
        data = leaves(result)[0]
        expected = knead.deform(start_of(data), knead.Session.read(session_file("move")), diagonal=diagonal,
                                precision="float64")
        require(np.array_equal(points_of(data), expected), f"other points at time {time}")
    require(data.GetNumberOfPoints() == leaves(opened("box.vtu"))[0].GetNumberOfPoints() or RANKS > 1, "not the last one")


run_tests(globals())

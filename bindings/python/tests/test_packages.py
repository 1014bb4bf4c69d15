"""deform_mesh with the meshes of other packages: the same kind back, the given one unchanged, deform's own numbers."""

import copy

import numpy as np
import pytest
from conftest import bits

import knead


@pytest.fixture
def paint():
    """A brush that reads the surface on its path."""
    path = [[0.2 * i - 0.4, 1, 0] for i in range(5)]
    return knead.Session([knead.Paint(outer=0.4, depth=0.05, path=path)])


@pytest.fixture
def tetrahedra():
    """Points of a block and its cells: five tetrahedra in each of 4 x 4 x 4 cubes."""
    n = 5
    grid = np.stack(np.meshgrid(*[np.linspace(-1, 1, n)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    corner = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)]) @ [n * n, n, 1]
    cut = np.array([[0, 3, 5, 6], [0, 1, 3, 5], [0, 2, 3, 6], [0, 4, 5, 6], [3, 5, 6, 7]])
    begin = np.array([[x, y, z] for x in range(n - 1) for y in range(n - 1) for z in range(n - 1)]) @ [n * n, n, 1]
    return grid, (begin[:, None, None] + corner[cut][None]).reshape(-1, 4)


def check_kind(mesh, name, session, faces=None, **accuracy):
    """Deforms a mesh; returns the result, whose positions are those of knead.deform."""
    before = np.array(getattr(mesh, name))
    moved = knead.deform_mesh(mesh, session)
    assert type(moved) is type(mesh) and moved is not mesh
    assert bits(np.asarray(getattr(mesh, name))) == bits(before)
    after = np.asarray(getattr(moved, name))
    expected = knead.deform(before, session, faces, **accuracy)
    assert after.dtype == expected.dtype and bits(after) == bits(expected)
    assert np.abs(after - before).max() > 0.01
    return moved


def test_shape_of_knead(sphere, session, paint, tmp_path):
    moved = check_kind(sphere, "vertices", session)
    check_kind(sphere, "vertices", paint, sphere.faces)
    moved.write(tmp_path / "moved.ply")
    assert len(knead.read(tmp_path / "moved.ply").faces) == len(sphere.faces)


def test_any_object(sphere, session, paint):
    class Mesh:
        def __init__(self):
            self.points, self.faces = sphere.vertices.copy(), sphere.faces.tolist()

    check_kind(Mesh(), "points", session)
    assert check_kind(Mesh(), "points", paint, sphere.faces).faces == sphere.faces.tolist()


def test_objects_without_points(session):
    with pytest.raises(TypeError, match="vertices or .points"):
        knead.deform_mesh([1, 2, 3], session)


@pytest.mark.parametrize("faces", [[-2], [3, 0, 1], [3, 0, 1, 2, 9], [3.0, 0, 1, 2], ["a"], [2**63]])
def test_flat_faces_that_cannot_be_read(faces, session):
    mesh = type("Mesh", (), {"points": np.eye(3), "faces": faces})()
    with pytest.raises((TypeError, knead.InvalidInput), match="faces"):
        knead.deform_mesh(mesh, session)


def test_trimesh(sphere, session, paint):
    trimesh = pytest.importorskip("trimesh")
    mesh = trimesh.Trimesh(sphere.vertices, sphere.faces, process=False)
    volume, normals = mesh.volume, mesh.vertex_normals.copy()  # kept by the object until its vertices change
    moved = check_kind(mesh, "vertices", session)
    assert np.array_equal(moved.faces, mesh.faces)
    measured = knead.check(moved.vertices, moved.faces)["volume"]
    assert moved.volume == pytest.approx(measured, rel=1e-9) and moved.volume != volume == mesh.volume
    assert np.abs(moved.vertex_normals - normals).max() > 0.1
    check_kind(mesh, "vertices", paint, sphere.faces)
    check_kind(trimesh.PointCloud(sphere.vertices), "vertices", session)


def test_meshio_surfaces(sphere, session, paint):
    meshio = pytest.importorskip("meshio")
    heat = np.arange(len(sphere.vertices), dtype=float)
    mesh = meshio.Mesh(sphere.vertices.copy(), [("triangle", sphere.faces)], point_data={"heat": heat})
    moved = check_kind(mesh, "points", session)
    assert np.array_equal(moved.cells[0].data, sphere.faces) and np.array_equal(moved.point_data["heat"], heat)
    check_kind(mesh, "points", paint, sphere.faces)


def test_meshio_faces_of_second_order_are_their_corners(sphere, paint):
    meshio = pytest.importorskip("meshio")
    v, f = sphere.vertices, sphere.faces
    middles = 0.5 * (v[f] + v[np.roll(f, -1, axis=1)]).reshape(-1, 3)
    faces = np.hstack([f, len(v) + np.arange(len(middles)).reshape(-1, 3)])
    check_kind(meshio.Mesh(np.vstack([v, middles]), [("triangle6", faces)]), "points", paint, f)


def test_meshio_volumes(tetrahedra, session, paint):
    meshio = pytest.importorskip("meshio")
    points, cells = tetrahedra
    mesh = meshio.Mesh(points, [("tetra", cells)])
    gentle = knead.Rotate(center=[0, 0, 0], axis=[0, 0, 1], angle_deg=10, inner=0.3, outer=1.5)
    moved = check_kind(mesh, "points", gentle, precision="double")  # the default where there are cells
    with pytest.raises(knead.AccuracyError, match="cells would be inverted"):
        knead.deform_mesh(mesh, session)
    assert np.array_equal(moved.cells[0].data, cells)

    def volumes(p):
        return np.linalg.det(p[cells[:, 1:]] - p[cells[:, :1]]) / 6

    assert np.sum(np.abs(volumes(points))) == pytest.approx(8)
    with pytest.raises(knead.InvalidInput):  # no surface to read
        knead.deform_mesh(mesh, paint)


def test_pyvista_quads(session):
    pyvista = pytest.importorskip("pyvista")
    mesh = pyvista.Box(bounds=(-1, 1, -1, 1, -1, 1), level=12, quads=True)
    moved = check_kind(mesh, "points", session)
    assert np.array_equal(moved.faces, mesh.faces) and moved.faces[0] == 4
    faces = mesh.faces.reshape(-1, 5)[:, 1:]
    paint = knead.Paint(outer=0.4, depth=0.05, path=[[0, 1, 0], [0.3, 1, 0]])
    check_kind(mesh, "points", paint, faces)


def test_pyvista_mixed_polygons(paint):
    pyvista = pytest.importorskip("pyvista")
    points = np.array([[-1, 1, -1], [1, 1, -1], [1, 1, 1], [-1, 1, 1], [2, 1, 0]], dtype=float)
    faces = [[3, 2, 1, 0], [1, 2, 4]]
    mesh = pyvista.PolyData(points, np.hstack([[len(f), *f] for f in faces]))
    wide = knead.Paint(outer=2, depth=0.05, path=[[0, 1, 0], [0.3, 1, 0]])
    check_kind(mesh, "points", wide, faces)


def test_pyvista_normals_and_points(sphere, session):
    pyvista = pytest.importorskip("pyvista")
    mesh = pyvista.Sphere(radius=1)
    plain = np.array(mesh.point_data["Normals"])  # stored in the object, so they would be wrong if they were kept
    assert mesh.points.dtype == np.float32
    moved = check_kind(mesh, "points", session)
    assert np.array_equal(mesh.point_data["Normals"], plain)
    fresh = pyvista.PolyData(moved.points, moved.faces).compute_normals(split_vertices=False, consistent_normals=False)
    assert np.allclose(moved.point_data["Normals"], fresh.point_data["Normals"])
    assert np.abs(moved.point_data["Normals"] - plain).max() > 0.1
    check_kind(pyvista.PolyData(sphere.vertices.copy()), "points", session)


def test_pyvista_volumes(tetrahedra, session):
    pyvista = pytest.importorskip("pyvista")
    points, cells = tetrahedra
    grid = pyvista.UnstructuredGrid(np.insert(cells, 0, 4, axis=1).ravel(), np.full(len(cells), 10), points)
    assert check_kind(grid, "points", session, precision="double").n_cells == len(cells)


def test_open3d(sphere, session, paint):
    open3d = pytest.importorskip("open3d")
    mesh = open3d.geometry.TriangleMesh()
    mesh.vertices = open3d.utility.Vector3dVector(sphere.vertices)
    mesh.triangles = open3d.utility.Vector3iVector(sphere.faces.astype(np.int32))
    mesh.compute_vertex_normals()
    normals = np.array(mesh.vertex_normals)
    moved = check_kind(mesh, "vertices", session)
    assert np.array_equal(np.asarray(moved.triangles), sphere.faces)
    assert np.array_equal(np.asarray(mesh.vertex_normals), normals)
    again = copy.copy(moved).compute_vertex_normals()
    assert np.allclose(np.asarray(moved.vertex_normals), np.asarray(again.vertex_normals))
    assert np.abs(np.asarray(moved.vertex_normals) - normals).max() > 0.1
    check_kind(mesh, "vertices", paint, sphere.faces)


def test_open3d_point_cloud(sphere, session):
    open3d = pytest.importorskip("open3d")
    cloud = open3d.geometry.PointCloud(open3d.utility.Vector3dVector(sphere.vertices))
    cloud.paint_uniform_color([1, 0, 0])
    assert check_kind(cloud, "points", session).has_colors()


def test_manifold3d(tmp_path):
    """A solid with a hole is bent by warp_batch, and by the command's way; both take part in a union."""
    manifold3d = pytest.importorskip("manifold3d")
    bar = manifold3d.Manifold.cube([120, 20, 6]) - manifold3d.Manifold.cylinder(20, 4, 4, 64).translate([60, 10, -5])
    stroke = knead.Curve(from_=[[0, 10, 3], [60, 10, 3], [120, 10, 3]], angle_deg=90, axis=[0, 1, 0])
    warped = bar.refine_to_length(1).warp_batch(knead.Flow(stroke))
    assert warped.status() == manifold3d.Error.NoError
    assert warped.volume() == pytest.approx(bar.volume(), rel=1e-3)

    mesh = bar.to_mesh()
    vertices, faces = np.array(mesh.vert_properties[:, :3], float), np.array(mesh.tri_verts)
    bent = knead.remesh(vertices, faces, stroke, max_chord=1e-4)
    solid = manifold3d.Manifold(manifold3d.Mesh(bent.vertices.astype(np.float32), bent.faces.astype(np.uint32)))
    assert solid.status() == manifold3d.Error.NoError
    assert solid.volume() == pytest.approx(bar.volume(), rel=1e-5)
    block = manifold3d.Manifold.cube([40, 40, 40], True).translate(bent.vertices.mean(axis=0))
    both = solid + block
    assert both.status() == manifold3d.Error.NoError
    assert max(solid.volume(), block.volume()) < both.volume() < solid.volume() + block.volume()

    knead.write(tmp_path / "bent.3mf", bent.vertices, bent.faces)
    back = knead.read(tmp_path / "bent.3mf")
    assert bits(back.vertices) == bits(bent.vertices) and np.array_equal(back.faces, bent.faces)


class Tetrahedron:
    """Tessellates as CAD programs do: each face has vertices of its own, and one face has become a line."""

    size = 1.0

    def tessellate(self, tolerance):
        corners = [(0, 0, 0), (self.size, 0, 0), (0, self.size, 0), (0, 0, self.size)]
        faces = [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3), (1, 2, 2)]
        return [corners[i] for face in faces for i in face], [(3 * i, 3 * i + 1, 3 * i + 2) for i in range(len(faces))]


def test_parts_are_closed_whatever_their_faces_share():
    for size in (1e-3, 1, 1e3):
        part = Tetrahedron()
        part.size = size
        shape = knead.from_build123d(part, 0.1)
        assert shape.vertices.shape == (4, 3) and len(shape.faces) == 4
        found = knead.check(shape)
        assert found["closed"] and found["manifold"]
        assert found["volume"] == pytest.approx(size**3 / 6, rel=1e-6)
    with pytest.raises(TypeError, match="a part of build123d or CadQuery"):
        knead.from_build123d(np.zeros((3, 3)))
    with pytest.raises(knead.InvalidInput, match="tolerance"):
        knead.from_build123d(Tetrahedron(), 0)


def test_build123d():
    build123d = pytest.importorskip("build123d")
    part = build123d.Box(30, 20, 6) - build123d.Cylinder(4, 20)
    shape = knead.from_build123d(part)
    found = knead.check(shape)
    assert found["closed"] and found["manifold"] and found["self_intersections"] == 0
    assert found["volume"] == pytest.approx(part.volume, rel=1e-3)
    bent = knead.remesh(shape, None, knead.Curve(angle_deg=60), max_chord=1e-3)
    assert knead.check(bent.vertices, bent.faces)["volume"] == pytest.approx(found["volume"], rel=1e-5)

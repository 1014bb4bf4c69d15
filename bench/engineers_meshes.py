"""Makes the meshes of bench/engineers_bench.py by gmsh: a pipe with a rod in it, and an airfoil, both with layers.

Run: /usr/bin/python3 bench/engineers_meshes.py FOLDER. Needs gmsh's module and numpy (Debian: python3-gmsh,
python3-numpy). Writes rod.msh and airfoil.msh, of hexahedra in layers and wedges elsewhere: gmsh meshes a plane with
boundary layers, whose first one is 1e-5 high, and this script sweeps it.
"""

import pathlib
import sys

import gmsh
import numpy as np

FIRST = 1e-5  # height of the first layer
_GROWTH = 1.25


def heights(count):
    """The tops of layers, the first one FIRST high, each next one _GROWTH as high as the one before."""
    return list(np.cumsum(FIRST * _GROWTH ** np.arange(count)))


def start():
    gmsh.initialize()
    gmsh.option.setNumber("General.Terminal", 0)
    gmsh.option.setNumber("Mesh.Algorithm", 6)
    gmsh.model.add("plane")


def mesh_around(inner, side, outer, count):
    """Meshes the plane between a loop of curves with layers and a loop of curves around it.

    side: 1 or -1, on which side of the curves the layers are. Returns points (n, 2), triangles, quads, and by the names
    inner and outer the edges.
    """
    geo = gmsh.model.geo
    grown = geo.extrudeBoundaryLayer([(1, c) for c in inner], [1] * count, [side * h for h in heights(count)], True)
    tops = [grown[i - 1] for i in range(1, len(grown)) if grown[i][0] == 2]
    geo.synchronize()
    loop = geo.addCurveLoop([tag for _, tag in tops], reorient=True)
    geo.addPlaneSurface([geo.addCurveLoop(outer), loop])
    geo.synchronize()
    gmsh.model.mesh.generate(2)
    tags, places, _ = gmsh.model.mesh.getNodes()
    number = np.zeros(int(tags.max()) + 1, int)
    number[tags] = np.arange(len(tags))
    faces = {}
    for kind, _, nodes in zip(*gmsh.model.mesh.getElements(2)):
        faces[kind] = number[np.array(nodes, int).reshape(-1, 3 if kind == 2 else 4)]
    edges = {}
    for name, curves in (("inner", inner), ("outer", outer)):
        parts = [np.array(n, int).reshape(-1, 2) for c in curves for n in gmsh.model.mesh.getElements(1, abs(c))[2]]
        edges[name] = number[np.concatenate(parts)]
    return np.asarray(places).reshape(-1, 3)[:, :2], faces[2], faces[3], edges


def facing_up(points, faces):
    """Returns the faces counter-clockwise."""
    a, b, c = (points[faces[:, k]] for k in range(3))
    turned = (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0] < 0
    faces[turned] = faces[turned][:, ::-1]
    return faces


def sweep(path, plane, levels, names):
    """Writes the plane's mesh, swept along z through the levels; names: of inner, outer, bottom, top."""
    points, triangles, quads, edges = plane
    triangles, quads = facing_up(points, triangles), facing_up(points, quads)
    used, index = np.unique(np.concatenate([triangles.ravel(), quads.ravel()]), return_inverse=True)
    triangles, quads = index[: triangles.size].reshape(-1, 3), index[triangles.size :].reshape(-1, 4)
    number = np.full(len(points), -1)
    number[used] = np.arange(len(used))
    points, n = points[used], len(used)
    rows = []  # gmsh's type, group, nodes
    for name, tag in (("inner", 1), ("outer", 2)):
        for a, b in number[edges[name]]:
            rows += [(3, tag, [a + k * n, b + k * n, b + (k + 1) * n, a + (k + 1) * n]) for k in range(len(levels) - 1)]
    for kind, faces in ((2, triangles), (3, quads)):
        for k, tag in ((0, 3), (len(levels) - 1, 4)):
            rows += [(kind, tag, face + k * n) for face in faces]
    for kind, faces in ((6, triangles), (5, quads)):
        for k in range(len(levels) - 1):
            rows += [(kind, 5, np.concatenate([face + k * n, face + (k + 1) * n])) for face in faces]
    with open(path, "w", encoding="ascii") as out:
        out.write("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n5\n")
        for tag, name in enumerate(names, 1):
            out.write(f'2 {tag} "{name}"\n')
        out.write(f'3 5 "fluid"\n$EndPhysicalNames\n$Nodes\n{n * len(levels)}\n')
        for k, z in enumerate(levels):
            for i, (x, y) in enumerate(points.tolist()):
                out.write(f"{k * n + i + 1} {x!r} {y!r} {float(z)!r}\n")
        out.write(f"$EndNodes\n$Elements\n{len(rows)}\n")
        for i, (kind, tag, nodes) in enumerate(rows, 1):
            out.write(f"{i} {kind} 2 {tag} {tag} {' '.join(str(v + 1) for v in nodes)}\n")
        out.write("$EndElements\n")


def circle(center, radius, points):
    """Adds a circle of four arcs, each with so many points."""
    geo = gmsh.model.geo
    middle = geo.addPoint(*center, 0)
    ring = [geo.addPoint(center[0] + radius * x, center[1] + radius * y, 0) for x, y in ((1, 0), (0, 1), (-1, 0), (0, -1))]
    arcs = [geo.addCircleArc(ring[k], middle, ring[(k + 1) % 4]) for k in range(4)]
    for arc in arcs:
        geo.mesh.setTransfiniteCurve(arc, points)
    return arcs


def rod(path):
    """A pipe of radius 1 and length 4 along z, with a rod of radius 0.25 all through it."""
    start()
    plane = mesh_around(circle((0, 0), 0.25, 13), 1, circle((0, 0), 1, 17), 28)
    gmsh.finalize()
    sweep(path, plane, np.linspace(0, 4, 41), ("rod", "wall", "inlet", "outlet"))


def airfoil(path):
    """NACA 0012 of chord 1, with a blunt end, in a circle of radius 4, one cell of 0.1 deep."""
    start()
    geo = gmsh.model.geo
    x = 0.5 * (1 + np.cos(np.linspace(0, np.pi, 61)))
    y = 0.6 * (0.2969 * np.sqrt(x) - 0.126 * x - 0.3516 * x**2 + 0.2843 * x**3 - 0.1015 * x**4)
    upper = [geo.addPoint(a, b, 0) for a, b in zip(x, y)]
    lower = [upper[-1], *(geo.addPoint(a, -b, 0) for a, b in zip(x[-2::-1], y[-2::-1]))]
    curves = [geo.addSpline(upper), geo.addSpline(lower), geo.addLine(lower[-1], upper[0])]
    for curve, count in zip(curves, (90, 90, 4)):
        geo.mesh.setTransfiniteCurve(curve, count)
    plane = mesh_around(curves, 1, circle((0.5, 0), 4, 17), 30)
    gmsh.finalize()
    sweep(path, plane, (0, 0.1), ("airfoil", "far", "front", "back"))


def main():
    folder = pathlib.Path(sys.argv[1])
    folder.mkdir(parents=True, exist_ok=True)
    rod(str(folder / "rod.msh"))
    airfoil(str(folder / "airfoil.msh"))


if __name__ == "__main__":
    main()

"""Shapes and their files."""

import json
import os
import warnings
from types import SimpleNamespace

from . import _knead
from ._arrays import faces_for


class Attributes(list):
    """The names of the attributes of a Shape; with a name as index, the numbers of one."""

    def __init__(self, shape):
        super().__init__(shape._native.attributes())
        self._shape = shape

    def __getitem__(self, name):
        return self._shape._native.attribute(name) if isinstance(name, str) else super().__getitem__(name)

    def __setitem__(self, name, values):
        import numpy

        shape = self._shape
        shape._native = shape._native.with_attribute(name, numpy.asarray(values), shape._vertices)
        super().__setitem__(slice(None), shape._native.attributes())


class Shape:
    """A shape and the file that it came from; made by read(), or from arrays.

    vertices: (n, 3), or a mesh of another package; faces: as for deform, None for a point cloud. Copies and pickles have
    arrays of their own.
    """

    def __init__(self, vertices, faces=None):
        is_native = isinstance(vertices, _knead.ShapeFile)
        self._native = vertices if is_native else _knead.shape_from(vertices, faces_for(vertices, faces))
        self._vertices = self._native.vertices()
        self._path, self._parts = "", None

    def __copy__(self):
        return _with_vertices(Shape(self._native), self._vertices, self._path)

    def __deepcopy__(self, memo):
        return self.__copy__()

    def __reduce__(self):
        if self.format == "gltf":
            raise TypeError("a Shape of a glTF file with files beside it cannot be pickled; send its path, or convert it to .glb")
        return _from_bytes, (self._native.bytes(), self.format, self._vertices, self._path)

    @property
    def vertices(self):
        """The positions of the vertices: (n, 3) float64. Assign another array of that shape, or change it in place."""
        return self._vertices

    @vertices.setter
    def vertices(self, vertices):
        import numpy  # not with the module: that takes most of the time of `import knead`

        given = numpy.asarray(vertices)
        if given.dtype.kind not in "fiu":
            raise TypeError(f"vertices must be an array of real numbers, got dtype {given.dtype}")
        array = numpy.array(given, dtype=numpy.float64, order="C")
        if array.shape != self._vertices.shape:
            raise _knead.InvalidInput(f"vertices must have shape {self._vertices.shape}, got {array.shape}")
        self._vertices = array

    @property
    def faces(self):
        """(m, 3) uint32 if all faces are triangles, else a list of arrays; without rows for a point cloud."""
        return self._native.faces()

    @property
    def triangles(self):
        """(k, 3) uint32: the faces, with polygons cut into triangles."""
        return self._native.triangles()

    @property
    def patches(self):
        """The named patches of a mesh of gmsh, SU2 or OpenFOAM, which the walls of sessions name: a new dict of arrays.

        Faces (m, 3), cut into triangles; edges (m, 2) of a mesh of two dimensions; the vertices (n,) of a group that has
        neither. Empty for other formats. Those of OpenFOAM are read from the files beside `points`.
        """
        return self._mesh_parts().patches()

    @property
    def splats(self):
        """The Gaussian splats that the file holds, as new arrays: Splats. deform_mesh() deforms a Shape that holds some."""
        from ._splats import splats_of

        return splats_of(self)

    def _mesh_parts(self):
        if self._parts is None:
            self._parts = _knead.parts_of_file(self._path, self._native)
        return self._parts

    @property
    def attributes(self):
        """What else the file holds for vertices, corners or faces: a list of names; with a name as index the numbers.

        shape.attributes["color"] is a new array with a row for each element, of the type that the file has; assign
        another of that shape, or one under a new name for each vertex, face or corner, as far as the format can hold it.
        Normals are those of the file; write() turns them with the vertices that have moved since they were read or set.
        """
        return Attributes(self)

    @property
    def format(self):
        """The format of the file: "ply", "obj" ..."""
        return self._native.format

    @property
    def notes(self):
        """What was odd in the file and how it was read; a sentence each."""
        return self._native.notes

    def write(self, path, *, double=False, decimals=None):
        """Writes the shape with its vertices where they are now, and everything else in the file as it was.

        The extension of `path` names the format. double: x y z of PLY files as doubles. decimals: digits after the
        point of coordinates that changed, in text files; None: as many as they need. Raises FileError; InvalidInput for
        an unknown extension.
        """
        if self._native.holds_splats() and (self._vertices != self._native.vertices()).any():
            warnings.warn("only the places of these splats have moved; deform_mesh() also changes their sizes, turns and colours", stacklevel=2)
        self._native.write(os.fspath(path), self._vertices, double, decimals)

    def _repr_png_(self):
        from ._deform import picture

        return picture(self)

    def __repr__(self):
        return f"<knead.Shape: {self.format}, {len(self._vertices)} vertices>"


def _with_vertices(shape, vertices, path):
    shape.vertices, shape._path = vertices, path
    return shape


def _from_bytes(data, format, vertices, path):
    return _with_vertices(Shape(_knead.parse_shape(data, format)), vertices, path)


def write(path, vertices, faces=None, *, double=False):
    """Writes a new file from arrays, or from a mesh of another package, in the format of the path's extension.

    vertices: (n, 3); faces: as for deform, None for a point cloud. double: coordinates of binary files as doubles.
    Raises as Shape.write.
    """
    Shape(vertices, faces).write(path, double=double)


def read(path):
    """Reads a shape from a file: PLY, OBJ, STL, OFF, glTF or points. The extension names the format.

    Raises FileError for a file that cannot be read, and InvalidInput with the line or byte for one that is malformed.
    """
    shape = Shape(_knead.read_shape(os.fspath(path)))
    shape._path = os.path.abspath(path)
    return shape


def crossings(vertices, faces=None):
    """Returns the pairs of faces that cross: (k, 2) uint32, the smaller number of a pair first as a rule.

    A face without area is a pair with itself, and a polygon one that crosses itself. More than 10 million pairs: none.
    """
    return _knead.crossings(vertices, faces_for(vertices, faces))


def check(vertices, faces=None):
    """Returns what `knead check --json` prints, as a dict: counts, closed, volume, self_intersections and more."""
    return json.loads(_knead.check(vertices, faces_for(vertices, faces)))


def check_cells(points, cells, before=None):
    """Returns what a deformation may spoil in the cells of a volume mesh, as a dict of arrays with a value for each cell.

    volume; scaled_jacobian, 1 at best, the least over the corners; non_orthogonality_deg and skewness, the worst of the
    faces, and aspect_ratio, as OpenFOAM's checkMesh defines them; inverted, exact: whether a corner has turned. With
    `before`, the points before the deformation, also volume_ratio, and inverted says whether a corner has turned since; a
    cell that was flat or tangled before is not counted.
    cells: (m, 4) tetrahedra, (m, 5) pyramids, (m, 6) wedges or (m, 8) hexahedra in VTK's order of corners; or the cells
    of a meshio mesh, of which surfaces, lines and points are left out. Wedges that look inward, as Gmsh numbers them, are
    turned, with a warning. Raises InvalidInput for a corner that is no point.
    """
    import numpy as np

    blocks = solid_blocks(points if before is None else before, cells)

    def measured(places):
        parts = [_knead.cell_qualities(places, block) for block in blocks]
        return [np.concatenate(arrays) for arrays in zip(*parts, strict=True)] if parts else [np.zeros(0)] * 3

    volume, jacobian, orientation = measured(points)
    angle, skewness, aspect = _knead.cell_face_qualities(points, blocks)
    faces = {"non_orthogonality_deg": angle, "skewness": skewness, "aspect_ratio": aspect}
    if before is None:
        return {"volume": volume, "scaled_jacobian": jacobian, "inverted": orientation != 1, **faces}
    first, _, was = measured(before)
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = volume / first
    turned = jacobian * np.where(was == -1, -1, 1)
    inverted = (orientation != was) & (was != 0)
    return {"volume": volume, "volume_ratio": ratio, "scaled_jacobian": turned, "inverted": inverted, **faces}


def volume_cells(mesh):
    """Returns the cells of a mesh of meshio or pyvista, for solid_blocks; none for other objects."""
    cells = getattr(mesh, "cells", None)
    if isinstance(cells, (list, tuple)):
        return cells if cells and all(hasattr(block, "type") for block in cells) else []
    solids = {10: "tetra", 12: "hexahedron", 13: "wedge", 14: "pyramid"}  # VTK's numbers
    kinds = getattr(mesh, "cells_dict", {})
    return [SimpleNamespace(type=solids[kind], data=data) for kind, data in kinds.items() if kind in solids]


def solid_blocks(points, cells):
    """Returns the volume cells as cell_blocks, with wedges that look inward turned."""
    blocks = cell_blocks(cells)
    wedges = [block.ndim == 2 and block.shape[1] == 6 for block in blocks]
    if not any(wedges) or not _knead.wedges_look_inward(points, blocks):
        return blocks
    warnings.warn("the wedges look inward, as Gmsh numbers them; they are read with their triangles turned", stacklevel=3)
    return [block[:, [0, 2, 1, 3, 5, 4]] if wedge else block for block, wedge in zip(blocks, wedges, strict=True)]


def cell_blocks(cells, is_flat=False):
    """Returns the volume cells as arrays: one of (m, 4), (m, 5), (m, 6) or (m, 8) for each block of a meshio mesh; of a
    mesh of two dimensions (m, 3) or (m, 4)."""
    import numpy as np

    solids = {"tetra": 4, "pyramid": 5, "wedge": 6, "hexahedron": 8}
    corners = {"triangle": 3, "quad": 4} if is_flat else solids
    if isinstance(cells, (list, tuple)) and all(hasattr(block, "type") for block in cells):
        kinds = [(block.data, block.type.rstrip("0123456789")) for block in cells]
        blocks = [np.asarray(data)[:, : corners[kind]] for data, kind in kinds if kind in corners]
    else:
        blocks = [np.asarray(cells)]
    for block in blocks:
        if block.dtype.kind not in "iu":
            raise TypeError(f"cells must be an array of whole numbers, got dtype {block.dtype}")
    return blocks

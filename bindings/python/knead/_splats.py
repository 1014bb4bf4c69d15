"""Gaussian splats as arrays."""

import os

from . import _knead
from ._knead import InvalidInput
from ._shapes import Shape

_HARMONICS = (1, 4, 9, 16)  # of degrees 0 to 3


class Splats:
    """Gaussian splats as arrays of numpy or tensors, in the numbers that their PLY files hold; made from arrays, or by
    Shape.splats. deform_mesh() takes and returns them, as arrays of the kind and type that they were given as.

    means: (n, 3). scales: (n, 3), logarithms of the standard deviations. rotations: (n, 4), quaternions w x y z.
    harmonics: (n, k, 3), the coefficients of red, green and blue: 1, 4, 9 or 16 for degrees 0 to 3. opacities: (n,),
    logits.
    """

    def __init__(self, means, scales, rotations, harmonics=None, opacities=None):
        for name, values in (("means", means), ("scales", scales), ("rotations", rotations)):
            if values is None or not hasattr(values, "__len__"):
                raise TypeError(f"{name} must be an array, got {values!r}")
        self.means, self.scales, self.rotations = means, scales, rotations
        self.harmonics, self.opacities = harmonics, opacities

    def __len__(self):
        return len(self.means)

    def write(self, path):
        """Writes a .ply, .splat, .glb or .gltf file, with all numbers as 32-bit floats. Raises as Shape.write."""
        _shape_of(self, "float32").write(os.fspath(path))

    def __repr__(self):
        return f"<knead.Splats: {len(self)}>"


def _array(values, dtype=None):
    """Returns an array of numpy, also from a tensor that has a gradient or is on a GPU."""
    import numpy as np

    if hasattr(values, "detach"):
        values = values.detach().cpu().numpy()
    array = np.asarray(values)
    if array.dtype.kind not in "fiu":
        raise TypeError(f"splats must be arrays of real numbers, got dtype {array.dtype}")
    return array.astype(dtype or (array.dtype if array.dtype in (np.float32, np.float64) else np.float64), copy=False)


def _shape_of(splats, dtype=None):
    """Returns a Shape with the splats' numbers."""
    given = {name: getattr(splats, name) for name in ("means", "scales", "rotations", "harmonics", "opacities")}
    arrays = {name: _array(values, dtype) for name, values in given.items() if values is not None}
    count = arrays["means"].shape[0] if arrays["means"].ndim else 0
    for name, shape in (("means", (count, 3)), ("scales", (count, 3)), ("rotations", (count, 4)), ("opacities", (count,))):
        if name in arrays and arrays[name].shape != shape:
            raise InvalidInput(f"{name} must have shape {shape}, got {arrays[name].shape}")
    columns = []
    if "harmonics" in arrays:
        harmonics = arrays["harmonics"]
        if harmonics.ndim != 3 or len(harmonics) != count or harmonics.shape[1] not in _HARMONICS or harmonics.shape[2] != 3:
            raise InvalidInput(f"harmonics must have shape ({count}, 1, 4, 9 or 16, 3), got {harmonics.shape}")
        columns += [(f"f_dc_{c}", harmonics[:, 0, c]) for c in range(3)]
        rest = harmonics[:, 1:].transpose(0, 2, 1).reshape(count, -1)
        columns += [(f"f_rest_{i}", rest[:, i]) for i in range(rest.shape[1])]
    if "opacities" in arrays:
        columns.append(("opacity", arrays["opacities"]))
    columns += [(f"scale_{i}", arrays["scales"][:, i]) for i in range(3)]
    columns += [(f"rot_{i}", arrays["rotations"][:, i]) for i in range(4)]
    return Shape(_knead.cloud_from(arrays["means"], columns))


def _like(values, given):
    """Returns the array as what was given: a tensor, or an array of its type."""
    if hasattr(given, "new_tensor"):
        return given.new_tensor(values)
    return values.astype(_array(given).dtype, copy=False)


def deform_arrays(splats, session, **options):
    """Returns the splats deformed, or None if `progress` returned False."""
    shape = deform_shape(_shape_of(splats), session, **options)
    if shape is None:
        return None
    moved = splats_of(shape)
    numbers = {name: getattr(splats, name) for name in ("means", "scales", "rotations", "harmonics", "opacities")}
    return Splats(**{n: None if given is None else _like(getattr(moved, n), given) for n, given in numbers.items()})


def deform_shape(shape, session, *, inverse=False, until=None, progress=None, max_splats=None, **accuracy):
    """Returns a Shape of splats deformed, with all else that its file holds; None if `progress` returned False."""
    from ._deform import _accuracy
    from ._session import native_session

    how = (_accuracy(**accuracy), bool(inverse), until, progress, max_splats)
    native = _knead.deform_file(shape.vertices, shape._native, native_session(session), *how)
    if native is None:
        return None
    moved = Shape(native)
    moved._path = shape._path
    return moved


def splats_of(shape):
    """Returns what Shape.splats does."""
    import numpy as np

    names = list(shape.attributes)
    if not shape._native.are_splats():
        raise InvalidInput("the shape holds no splats: points with scale_0 to scale_2 and rot_0 to rot_3")

    def columns(name, count):
        return np.stack([shape.attributes[f"{name}_{i}"] for i in range(count)], axis=-1)

    harmonics = columns("f_dc", 3)[:, None] if "f_dc_2" in names else None
    rest = sum(name.startswith("f_rest_") for name in names)
    if harmonics is not None and rest:
        by_channel = columns("f_rest", rest).reshape(len(shape.vertices), 3, rest // 3)
        harmonics = np.concatenate([harmonics, by_channel.transpose(0, 2, 1)], axis=1)
    opacities = shape.attributes["opacity"] if "opacity" in names else None
    return Splats(shape.vertices, columns("scale", 3), columns("rot", 4), harmonics, opacities)

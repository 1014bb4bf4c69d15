"""Populations of shapes: their mean, and how they differ, as flows of one of them."""

from . import _knead
from ._fit import _points, _shape, fit


class Population:
    """Shapes that all have been fitted by one of them, the template, whose vertices they share.

    template: (vertices, faces). fits: a Fit of the template to each shape. aligned: (m, n, 3), the template's vertices on each
        shape, turned and moved to lie upon each other. mean: a Fit of the template to their mean: a flow, so that the
        mean shape, mean.vertices, crosses itself no more than the template does; mean.session is for the template.
    modes: (k, n, 3), how shapes differ from the mean, as displacements of the vertices at one standard deviation; those that
        explain most come first. deviations: (k,), their root mean squares. weights: (m, k), of each shape in standard deviations.
    """

    def __init__(self, template, fits, aligned, mean, modes, weights, options):
        import numpy as np

        self.template = template
        self.fits = fits
        self.aligned = aligned
        self.mean = mean
        self.modes = modes
        self.deviations = np.sqrt((modes**2).sum(axis=2).mean(axis=1))
        self.weights = weights
        self._options = options

    def __repr__(self):
        return f"<knead.Population: {len(self.fits)} shapes, {len(self.modes)} modes>"

    def along(self, weights, *, progress=None):
        """Returns a Fit of the template to the mean and so many standard deviations of the modes.

        weights: one number for each of the first modes. Its session is for the template; its vertices may differ a little from
        aligned.mean(axis=0) + weights . modes, for a flow lets nothing cross.
        Raises InvalidInput for more numbers than there are modes, and for numbers that are not finite.
        """
        import numpy as np

        weights = np.asarray(weights, dtype=float).ravel()
        if len(weights) > len(self.modes) or not np.isfinite(weights).all():
            raise _knead.InvalidInput(f"weights must be at most {len(self.modes)} finite numbers")
        wanted = self.aligned.mean(axis=0) + np.tensordot(weights, self.modes[: len(weights)], axes=1)
        return _to_vertices(self.template, wanted, {**self._options, "progress": progress})


def _to_vertices(template, wanted, options):
    """A fit of the template that takes each vertex about to its place."""
    import numpy as np

    vertices, faces = template
    every = max(1, len(vertices) // 1500)
    chosen = np.arange(0, len(vertices), every)
    pairs = np.concatenate([vertices[chosen], wanted[chosen]], axis=1)
    return fit(template, (wanted, faces), map=pairs, align=False, **options)


def _moved_onto(points, target):
    """Returns points turned and moved as a whole so that they lie nearest to as many others (Kabsch)."""
    import numpy as np

    middle = points.mean(axis=0)
    u, _, vt = np.linalg.svd((points - middle).T @ (target - target.mean(axis=0)))
    u[:, -1] *= np.sign(np.linalg.det(u @ vt))
    return (points - middle) @ (u @ vt) + target.mean(axis=0)


def mean(shapes, *, template=0, landmarks=None, maps=None, volume="free", align=True, max_stretch=5, threads=0, progress=None):
    """Fits one of the shapes to all, and returns a Population: their mean shape and modes, as flows.

    shapes: two or more shapes, or (vertices, faces).
    template: the number of the shape that is fitted to the others, or a shape of its own.
    landmarks, maps: None, or for each of the shapes pairs of the template and it, as for fit; None for the template itself.
    volume, align, max_stretch, threads: as for fit, but that volume cannot be "total": people differ in volume.
    progress: is called with the fraction done, as for deform. If it returned False, mean returns None.

    Raises InvalidInput as fit, and for fewer than two shapes. A fit that is not sound says so: Population.fits[i].problem.
    Time: one fit for each shape, and one for the mean.
    """
    import numpy as np

    shapes = list(shapes)
    if len(shapes) < 2:
        raise _knead.InvalidInput(f"a mean needs two or more shapes, got {len(shapes)}")
    if volume == "total":
        raise _knead.InvalidInput('volume must be "keep" or "free" for a mean, got "total"')
    is_number = isinstance(template, (int, np.integer))
    if is_number and not 0 <= template < len(shapes):
        raise _knead.InvalidInput(f"template must be from 0 to {len(shapes) - 1}, or a shape, got {template}")
    own = shapes[template] if is_number else template
    vertices, faces = _shape(own, "template")
    vertices = np.array(_points(vertices))
    if faces is None:
        raise _knead.InvalidInput("a template needs faces")
    lists = []
    for name, given in (("landmarks", landmarks), ("maps", maps)):
        lists.append([None] * len(shapes) if given is None else list(given))
        if len(lists[-1]) != len(shapes):
            raise _knead.InvalidInput(f"{name} must hold one entry for each of the {len(shapes)} shapes, got {len(lists[-1])}")
    options = {"volume": volume, "max_stretch": max_stretch, "threads": threads}
    fits = []
    for i, (shape, pairs, start) in enumerate(zip(shapes, *lists)):
        part = None if progress is None else lambda done, i=i: progress((i + done) / (len(shapes) + 1))
        made = fit((vertices, faces), shape, pairs, start, align=align, progress=part, **options)
        if made is None:
            return None
        fits.append(made)
    places = [made.vertices for made in fits]
    middle = vertices
    for _ in range(3):
        places = [_moved_onto(points, middle) for points in places]
        middle = np.mean(places, axis=0)
    aligned = np.array([_moved_onto(points, _moved_onto(middle, vertices)) for points in places])
    part = None if progress is None else lambda done: progress((len(shapes) + done) / (len(shapes) + 1))
    of_mean = _to_vertices((vertices, faces), aligned.mean(axis=0), {**options, "progress": part})
    if of_mean is None:
        return None
    off = (aligned - aligned.mean(axis=0)).reshape(len(aligned), -1)
    u, s, vt = np.linalg.svd(off, full_matrices=False)
    kept = s > 1e-9 * max(s[0], 1e-300)
    scale = s[kept] / np.sqrt(len(aligned) - 1)
    modes = (vt[kept] * scale[:, None]).reshape(-1, len(vertices), 3)
    return Population((vertices, faces), fits, aligned, of_mean, modes, u[:, kept] * np.sqrt(len(aligned) - 1), options)

"""Deformations whose parameters and points PyTorch and JAX differentiate.

    from knead.autograd import torch_deform
    values = torch.tensor([30.0, 0.1], dtype=torch.float64, requires_grad=True)
    moved = torch_deform(session, points, values)
    objective(moved).backward()  # values.grad, and points.grad if they require it

`values` holds a number for each parameter of the session, in the order of `session.parameters`. PyTorch and JAX are
imported when they are first asked for.
"""

import functools

import numpy as np

from ._deform import deform
from ._knead import InvalidInput


class _Map:
    """How a session with parameters moves points, and its derivatives, all in float64."""

    def __init__(self, session, relative_tolerance):
        self.session = session
        self.names = list(session.parameters)
        self.tolerance = relative_tolerance

    def at(self, values):
        values = np.asarray(values, dtype=np.float64)
        if values.shape != (len(self.names),):
            raise InvalidInput(f"values must be a vector of {len(self.names)} numbers ({', '.join(self.names)}), "
                               f"got the shape {values.shape}")
        return self.session(**dict(zip(self.names, values.tolist())))

    def move(self, points, values):
        return deform(np.asarray(points, np.float64), self.at(values), precision="float64", relative_tolerance=self.tolerance)

    def jvp(self, points, values, direction):
        direction = np.asarray(direction, dtype=np.float64).tolist()
        return self.at(values).jvp(points, direction, relative_tolerance=self.tolerance)[1]

    def vjp(self, points, values, gradient):
        """Returns the gradients with respect to the points and to the values."""
        gradient = np.asarray(gradient, dtype=np.float64)
        of_points, slopes = self.at(values).vjp(points, gradient, of_points=True, relative_tolerance=self.tolerance)
        return of_points, np.array([slopes[name] for name in self.names])


@functools.lru_cache(maxsize=None)
def _torch_function():
    import torch

    def like(array, tensor):
        return torch.as_tensor(array, dtype=tensor.dtype, device=tensor.device)

    class Deform(torch.autograd.Function):
        """The map as a function that PyTorch differentiates backwards, and forwards with respect to the values."""

        @staticmethod
        def forward(ctx, points, values, way):
            ctx.points, ctx.values, ctx.way = points.detach(), values.detach(), way
            return like(way.move(ctx.points.cpu().numpy(), ctx.values.cpu().numpy()), values)

        @staticmethod
        @torch.autograd.function.once_differentiable
        def backward(ctx, gradient):
            host = [tensor.detach().cpu().numpy() for tensor in (ctx.points, ctx.values, gradient)]
            of_points, slopes = ctx.way.vjp(*host)
            return like(of_points, ctx.points), like(slopes, ctx.values), None

        @staticmethod
        def jvp(ctx, points, values, _):
            if points is not None and points.any():
                raise InvalidInput("forwards the points have no derivative; use backward()")
            host = [tensor.detach().cpu().numpy() for tensor in (ctx.points, ctx.values, values)]
            return like(ctx.way.jvp(*host), ctx.values)

    return Deform


def torch_deform(session, points, values, *, relative_tolerance=1e-9):
    """Returns the deformed points as a tensor (n, 3) that PyTorch differentiates with respect to `values` and `points`.

    session: a Session with parameters that reads no surface. points: array-like (n, 3), or a tensor. values: a tensor
    of a number for each parameter, of float64 for full accuracy. relative_tolerance: as for Session.jvp. A second
    derivative is refused. Raises InvalidInput as Session.jvp and deform.
    """
    import torch

    return _torch_function().apply(torch.as_tensor(points), values, _Map(session, relative_tolerance))


def jax_deform(session, points, values, *, relative_tolerance=1e-9):
    """Returns the deformed points as an array (n, 3) that JAX differentiates backwards by `values` and `points`.

    Works in jax.grad and jax.jit: the points are moved on the host. The arguments are those of torch_deform. Enable
    64-bit numbers (jax_enable_x64) for full accuracy.
    """
    import jax

    way = _Map(session, relative_tolerance)

    def on_host(function, like, *arguments):
        results = tuple(jax.ShapeDtypeStruct(array.shape, dtype) for array, dtype in like)
        return jax.pure_callback(
            lambda *given: tuple(r.astype(dtype) for r, (_, dtype) in zip(function(*given), like)), results, *arguments)

    @jax.custom_vjp
    def moved(points, numbers):
        return on_host(lambda *given: [way.move(*given)], [(points, numbers.dtype)], points, numbers)[0]

    def backward(given, gradient):
        return on_host(way.vjp, [(array, array.dtype) for array in given], *given, gradient)

    moved.defvjp(lambda *given: (moved(*given), given), backward)
    return moved(jax.numpy.asarray(points), jax.numpy.asarray(values))

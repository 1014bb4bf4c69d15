"""Deformations whose parameters PyTorch and JAX differentiate.

    from knead.autograd import torch_deform
    values = torch.tensor([30.0, 0.1], dtype=torch.float64, requires_grad=True)
    moved = torch_deform(session, points, values)
    objective(moved).backward()  # values.grad

`values` holds a number for each parameter of the session, in the order of `session.parameters`. The points have no
derivative. PyTorch and JAX are imported when they are first asked for.
"""

import functools

import numpy as np

from ._deform import deform
from ._knead import InvalidInput


class _Map:
    """How a session with parameters moves points, and its derivatives, all in float64."""

    def __init__(self, session, points, relative_tolerance):
        self.session = session
        self.points = np.array(points, dtype=np.float64)
        self.names = list(session.parameters)
        self.tolerance = relative_tolerance

    def at(self, values):
        values = np.asarray(values, dtype=np.float64)
        if values.shape != (len(self.names),):
            raise InvalidInput(f"values must be a vector of {len(self.names)} numbers ({', '.join(self.names)}), "
                               f"got the shape {values.shape}")
        return self.session(**dict(zip(self.names, values.tolist())))

    def move(self, values):
        return deform(self.points, self.at(values), precision="float64", relative_tolerance=self.tolerance)

    def jvp(self, values, direction):
        direction = np.asarray(direction, dtype=np.float64).tolist()
        return self.at(values).jvp(self.points, direction, relative_tolerance=self.tolerance)[1]

    def vjp(self, values, gradient):
        gradient = np.asarray(gradient, dtype=np.float64)
        slopes = self.at(values).vjp(self.points, gradient, relative_tolerance=self.tolerance)
        return np.array([slopes[name] for name in self.names])


@functools.lru_cache(maxsize=None)
def _torch_function():
    import torch

    class Deform(torch.autograd.Function):
        """The map as a function that PyTorch differentiates backwards and forwards."""

        @staticmethod
        def forward(ctx, values, way):
            ctx.values, ctx.way = values.detach(), way
            return torch.as_tensor(way.move(values.detach().cpu().numpy()), dtype=values.dtype, device=values.device)

        @staticmethod
        @torch.autograd.function.once_differentiable
        def backward(ctx, gradient):
            slopes = ctx.way.vjp(ctx.values.cpu().numpy(), gradient.detach().cpu().numpy())
            return torch.as_tensor(slopes, dtype=ctx.values.dtype, device=ctx.values.device), None

        @staticmethod
        def jvp(ctx, direction, _):
            moves = ctx.way.jvp(ctx.values.cpu().numpy(), direction.detach().cpu().numpy())
            return torch.as_tensor(moves, dtype=ctx.values.dtype, device=ctx.values.device)

    return Deform


def torch_deform(session, points, values, *, relative_tolerance=1e-9):
    """Returns the deformed points as a tensor (n, 3) that PyTorch differentiates with respect to `values`.

    session: a Session with parameters that reads no surface. points: array-like (n, 3), or a tensor without a gradient.
    values: a tensor of a number for each parameter, of float64 for full accuracy. relative_tolerance: as for
    Session.jvp. A second derivative is refused. Raises InvalidInput as Session.jvp and deform.
    """
    if getattr(points, "requires_grad", False):
        raise InvalidInput("the points have no derivative; give points.detach()")
    if hasattr(points, "cpu"):
        points = points.cpu().numpy()
    return _torch_function().apply(values, _Map(session, points, relative_tolerance))


def jax_deform(session, points, values, *, relative_tolerance=1e-9):
    """Returns the deformed points as an array (n, 3) that JAX differentiates backwards with respect to `values`.

    Works in jax.grad and jax.jit: the points are moved on the host. The arguments are those of torch_deform; `points`
    must be numbers, and not traced. Give 64-bit values (jax_enable_x64) for full accuracy.
    """
    import jax

    way = _Map(session, points, relative_tolerance)

    def on_host(function, shape, dtype, *arguments):
        result = jax.ShapeDtypeStruct(shape, dtype)
        return jax.pure_callback(lambda *given: function(*given).astype(dtype), result, *arguments)

    @jax.custom_vjp
    def moved(numbers):
        return on_host(way.move, way.points.shape, numbers.dtype, numbers)

    def backward(numbers, gradient):
        return (on_host(way.vjp, numbers.shape, numbers.dtype, numbers, gradient),)

    moved.defvjp(lambda numbers: (moved(numbers), numbers), backward)
    return moved(jax.numpy.asarray(values))

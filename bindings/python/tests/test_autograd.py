"""knead.autograd: PyTorch and JAX find the derivatives of Session.vjp and Session.jvp. Skipped where they are missing."""

import numpy as np
import pytest

import knead
from knead import autograd

BAR = {"tool": "bend", "center": [0, 0, 0], "axis": [0, 1, 0], "normal": [-1, 0, 0], "width": 1, "angle_deg": "$angle"}
PULL = {"tool": "implicit", "path": [[0, 0, 0.5], [0, "$bump", 0.5]], "inner": 0.1, "outer": 1}
SESSION = knead.Session([BAR, PULL], parameters={"angle": (30, 0, 90), "bump": 0.1})
POINTS = np.random.default_rng(20261126).uniform(-1, 1, (50, 3))
TARGET = knead.deform(POINTS, SESSION(angle=41, bump=0.2), precision="float64", relative_tolerance=1e-10)


def slopes(values):
    """The gradients of half the squared distance to the target by points and parameters, by Session.vjp."""
    session = SESSION(**dict(zip(SESSION.parameters, values)))
    moved = knead.deform(POINTS, session, precision="float64", relative_tolerance=1e-9)
    of_points, by_name = session.vjp(POINTS, moved - TARGET, of_points=True)
    return of_points, list(by_name.values())


def test_the_map_is_that_of_the_session():
    way = autograd._Map(SESSION, 1e-9)
    assert np.allclose(way.move(POINTS, [41, 0.2]), TARGET, atol=1e-8)
    gradient = TARGET - POINTS
    both = [way.jvp(POINTS, [30, 0.1], direction) for direction in ([1, 0], [0, 1])]
    assert np.allclose(way.vjp(POINTS, [30, 0.1], gradient)[1], [(tangents * gradient).sum() for tangents in both], rtol=1e-6)
    with pytest.raises(knead.InvalidInput, match=r"2 numbers \(angle, bump\)"):
        way.move(POINTS, [1])


def test_torch_differentiates_it():
    torch = pytest.importorskip("torch")
    values = torch.tensor([30.0, 0.1], dtype=torch.float64, requires_grad=True)
    points = torch.tensor(POINTS, requires_grad=True)
    moved = autograd.torch_deform(SESSION, points, values)
    assert moved.dtype == torch.float64 and moved.shape == (50, 3)
    (0.5 * (moved - torch.tensor(TARGET)) ** 2).sum().backward()
    of_points, of_values = slopes([30, 0.1])
    assert np.allclose(values.grad.numpy(), of_values, rtol=1e-6)
    assert np.allclose(points.grad.numpy(), of_points, atol=1e-7)
    from torch.autograd import forward_ad
    with forward_ad.dual_level():
        dual = forward_ad.make_dual(values.detach(), torch.tensor([1.0, 0.0], dtype=torch.float64))
        tangents = forward_ad.unpack_dual(autograd.torch_deform(SESSION, POINTS, dual)).tangent
        with pytest.raises(knead.InvalidInput, match="forwards the points have no derivative"):
            autograd.torch_deform(SESSION, forward_ad.make_dual(torch.tensor(POINTS), torch.ones(50, 3, dtype=torch.float64)), dual)
    assert np.allclose(tangents.numpy(), SESSION.jvp(POINTS, {"angle": 1})[1], atol=1e-9)


def test_an_optimiser_of_torch_finds_the_target():
    torch = pytest.importorskip("torch")
    values = torch.tensor([30.0, 0.1], dtype=torch.float64, requires_grad=True)
    optimiser = torch.optim.LBFGS([values], line_search_fn="strong_wolfe", max_iter=60, tolerance_grad=1e-9)

    def closure():
        optimiser.zero_grad()
        distance = ((autograd.torch_deform(SESSION, POINTS, values) - torch.tensor(TARGET)) ** 2).sum()
        distance.backward()
        return distance

    optimiser.step(closure)
    assert np.allclose(values.detach().numpy(), [41, 0.2], rtol=1e-3)


def test_jax_differentiates_it():
    jax = pytest.importorskip("jax")
    jax.config.update("jax_enable_x64", True)

    def distance(points, values):
        return 0.5 * ((autograd.jax_deform(SESSION, points, values) - TARGET) ** 2).sum()

    aims = slopes([30, 0.1])
    for gradient_of in (jax.grad(distance, (0, 1)), jax.jit(jax.grad(distance, (0, 1)))):
        of_points, of_values = gradient_of(POINTS, np.array([30, 0.1]))
        assert np.allclose(of_values, aims[1], rtol=1e-6) and np.allclose(of_points, aims[0], atol=1e-7)
    assert np.allclose(autograd.jax_deform(SESSION, POINTS, np.array([41, 0.2])), TARGET, atol=1e-8)

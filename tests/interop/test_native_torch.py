# SPDX-License-Identifier: BSD-3-Clause
"""Machine code that PyTorch calls, beside the same operations as PyTorch's own: values, axes, derivatives of both modes and orders."""

import numpy as np
import pytest

import kane as kn
from kane.gallery import pendulums, rolling_disk
from tests.interop.test_autodiff import close, state
from tests.peer import require

torch = require("torch")  # not collected without it (tests/conftest.py)
pytestmark = pytest.mark.filterwarnings("ignore:.torch.jit.script:DeprecationWarning")  # its own forward mode warns


def tensor(values):
    return torch.tensor(np.asarray(values), dtype=torch.float64)


@pytest.fixture(scope="module", params=["rods", pytest.param("disk", marks=pytest.mark.slow)])
def both(request):
    eom = kn.derive(pendulums.system(2) if request.param == "rods" else rolling_disk.system())
    return eom, kn.exchange.to_torch(eom, native=True), kn.exchange.to_torch(eom)


def test_values_with_axes_that_broadcast_in_any_order(both):
    eom, native, traced = both
    x = tensor([state(eom, k) for k in range(3)])
    p = tensor(eom.compile().parameters() * np.array([[1.0], [1.1]]))
    close(native(0.2, x[0]), eom.compile().rhs(0.2, x[0].numpy()))
    t = torch.arange(2.0, dtype=torch.float64)
    close(native(t, x[:, None], p), traced(t, x[:, None], p))

    def nested(f):
        return torch.func.vmap(torch.func.vmap(lambda x, p: f(0.2, x, p), (0, None)), (None, 0))(x, p)

    close(nested(native), nested(traced))
    assert native(0.2, x[:0]).shape == x[:0].shape


def test_derivatives_in_both_modes_under_maps_and_once_more(both):
    eom, native, traced = both
    compiled = eom.compile()
    t, x, p = tensor(0.2), tensor(state(eom)), tensor(compiled.parameters())
    for mode in (torch.func.jacfwd, torch.func.jacrev):
        found, expected = (mode(f, (0, 1, 2))(t, x, p) for f in (native, traced))
        for one, other in zip(found, expected, strict=True):
            close(one, other)
        close(found[1], compiled.jac(0.2, x.numpy()))
    rows = torch.stack([x, 1.1 * x])

    def grad_of_map(f):
        return torch.func.grad(lambda rows: torch.func.vmap(lambda y: f(0.2, y)[-1] ** 2)(rows).sum())(rows)

    close(grad_of_map(native), grad_of_map(traced))
    for outer in (torch.func.jacfwd, torch.func.jacrev):
        close(*(outer(torch.func.jacrev(lambda y, f=f: f(0.2, y)[-1]))(x) for f in (native, traced)))


def test_a_shared_vector_gets_the_sum_of_the_gradients_of_all_rows(both):
    """Through `backward`, and through it once more."""
    eom, native, traced = both
    rows = [tensor([state(eom, k) for k in range(3)]).requires_grad_() for _ in range(2)]
    shared = [tensor(eom.compile().parameters()).requires_grad_() for _ in range(2)]
    for f, x, p in zip((native, traced), rows, shared, strict=True):
        (slope,) = torch.autograd.grad((f(0.2, x, p) ** 2).sum(), p, create_graph=True)
        (slope**2).sum().backward()
    for own, other in (rows, shared):
        assert own.grad.shape == own.shape
        close(own.grad, other.grad)


@pytest.mark.slow
def test_a_motion_is_differentiated_through_its_steps():
    eom = kn.derive(pendulums.system(4))
    slopes = []
    for native in (True, False):
        f = kn.exchange.to_torch(eom, native=native)
        y = x = tensor(state(eom)).requires_grad_()
        for _ in range(50):
            y = y + 1e-2 * f(0.0, y)
        slopes += torch.autograd.grad(y.sum(), x)
    close(*slopes)
    for name in ("mass_matrix", "reactions"):  # without compiled derivatives, and without results
        pair = [kn.exchange.to_torch(eom, name, native=n) for n in (True, False)]
        for mode in (torch.func.jacfwd, torch.func.jacrev):
            close(*(mode(lambda y, f=f: f(0.0, y))(x.detach()) for f in pair))


def test_what_is_not_finite_passes_on_and_another_device_is_refused(both):
    eom, native, _ = both
    x = tensor(state(eom))
    x[0] = torch.nan
    assert torch.isnan(native(0.0, x)).any()
    with pytest.raises(kn.ArgumentError, match="Expected CPU tensors for machine code, got one on meta"):
        native(0.0, x.to("meta"))

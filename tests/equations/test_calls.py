# SPDX-License-Identifier: BSD-3-Clause
"""Calls that are quick: values by name once they were seen, many states; they give and refuse what the careful way does."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import kane as kn
from kane.equations.handle import Handle
from kane.gallery import pendulum_on_cart

EOM = kn.derive(pendulum_on_cart.system(force=True))
X = np.array([0.1, 0.2, 0.3, 0.4])
P = {s: 1.0 + k for k, s in enumerate(EOM.parameters)}
ROWS = np.random.default_rng(0).normal(size=(7, 4))


@pytest.fixture
def rhs():
    return EOM.compile().rhs


@pytest.fixture
def careful(monkeypatch):
    """How often the careful way was taken."""
    calls = []
    general = Handle._general

    def counted(self, *inputs):
        calls.append(inputs)
        return general(self, *inputs)

    monkeypatch.setattr(Handle, "_general", counted)
    return calls


def test_names_that_were_seen(rhs, careful):
    p = np.array(list(P.values()))
    wanted = rhs(0.0, X, p, np.array([2.0]))
    for given in (P, {s.name: v for s, v in P.items()}, dict(reversed(P.items()))):
        for r in ({"F": 2.0}, {EOM.inputs[0]: 2}, {"F": np.float64(2)}, np.array([2.0])):
            before = len(careful)
            for _ in range(3):
                assert np.array_equal(rhs(0.0, X, given, r), wanted)
            assert len(careful) - before <= 1
    less = {EOM.parameters[0]: 5.0}
    for _ in range(3):
        assert np.array_equal(rhs(0.0, X, less, {"F": 2.0}), rhs(0.0, X, EOM.compile().parameters(less), {"F": 2.0}))


def test_names_that_were_seen_are_those_of_their_port(rhs):
    """The name of an input among the parameters stays an error, and so does what is no number."""
    for _ in range(3):
        rhs(0.0, X, P, {"F": 2.0})
        with pytest.raises(kn.ValueMissingError, match="F"):
            rhs(0.0, X, {"F": 2.0}, {"F": 2.0})
        with pytest.raises(kn.ArgumentError, match="Expected real numbers"):
            rhs(0.0, X, P, {"F": "much"})
        with pytest.raises(kn.ArgumentError, match="Expected finite"):
            rhs(0.0, X, P, {"F": np.nan})
        with pytest.raises(kn.ValueMissingError, match="got none for F"):
            rhs(0.0, X, P, {})
        assert rhs(0.0, X, P, {"F": np.array([1.0, 2.0])}).shape == (2, 4)


def test_many_states(rhs, careful):
    r, p = np.array([2.0]), np.array(list(P.values()))
    wanted = np.array([rhs(0.5, x, p, r) for x in ROWS])
    assert np.array_equal(rhs(0.5, ROWS, p, r), wanted)
    assert np.array_equal(rhs(0.5, ROWS, None, r), np.array([rhs(0.5, x, None, r) for x in ROWS]))
    assert not careful
    for odd in (ROWS[:, ::-1][:, ::-1], np.asfortranarray(ROWS), ROWS.astype(np.float32).astype(float), ROWS.tolist()):
        assert np.array_equal(rhs(0.5, odd, p, r), np.array([rhs(0.5, x, p, r) for x in np.array(odd)]))
    assert rhs(0.5, ROWS[:0], p, r).shape == (0, 4)
    with pytest.raises(kn.ArgumentError, match="Expected finite states"):
        rhs(0.5, np.where(ROWS[2, 1] == ROWS, np.nan, ROWS), p, r)
    with pytest.raises(kn.ArgumentError, match="shape"):
        rhs(0.5, ROWS[:, :3].copy(), p, r)
    with pytest.raises(kn.ArgumentError, match="Expected finite inputs"):
        rhs(0.5, ROWS, p, np.array([np.inf]))
    assert np.isfinite(rhs(0.5, ROWS * 1e200 * 0 + 1, p, r)).all()


def test_implicit_solvers_take_the_exact_jacobian():
    """Of a system with a cyclic coordinate, where differences fail."""
    N = kn.Frame("N")
    x, q = kn.coordinates("x q")
    v, w = kn.speeds("v w")
    O = kn.Point("O", fixed_in=N)
    P1 = O.at("P1", x * N.x)
    A = N.rotate("A", q, N.z)
    P2 = P1.at("P2", A.x)
    eom = kn.derive(
        kn.System(
            N,
            bodies=[kn.Particle("a", P1, 1.0), kn.Particle("b", P2, 2.0)],
            speeds={v: x.dt, w: q.dt},
            loads=[kn.gravity(-9.81 * N.y), kn.Torque(A, -1e4 * w * N.z)],
        )
    )
    code = eom.compile()
    y = np.array([0, 1.0, 0.2, 0])
    for method in ("Radau", "BDF", "LSODA"):
        done = solve_ivp(code.rhs, (0, 100), y, method=method, jac=code.jac, rtol=1e-8, atol=1e-10)
        assert done.success
        momentum = 3 * done.y[2] - 2 * done.y[3] * np.sin(done.y[1])
        assert np.abs(momentum - momentum[0]).max() < 1e-5

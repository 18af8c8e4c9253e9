# SPDX-License-Identifier: BSD-3-Clause
"""Calls that are quick: values by name once they were seen, many states; they give and refuse what the careful way does."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import kane as kn
from kane import Handle
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


def test_rows_in_every_port(rhs, careful):
    """Rows in some ports and one value in the others, however they are given, are what single calls give, bit for bit."""
    p, few = np.array(list(P.values())), {EOM.parameters[1]: 3.0}
    many = {
        "t": np.linspace(0.0, 1.0, 7),
        "x": ROWS,
        "p": p * np.linspace(1.0, 2.0, 7)[:, None],
        "r": np.linspace(-1.0, 1.0, 7)[:, None],
    }
    for few_or_all in (few, P):
        rhs(0.0, X, few_or_all, {"F": 1.0})
    careful.clear()
    shared = {
        "t": (0.5, 0, np.float64(0.5)),
        "x": (X,),
        "p": (p, None, few, P),
        "r": (np.array([2.0]), {"F": 2}),
    }
    strided = {name: np.repeat(a, 2, axis=0)[::2] for name, a in many.items()}
    for mask in range(1, 16):
        by_rows = [name for k, name in enumerate(many) if mask >> k & 1]
        for pick in range(4):
            one = {name: ways[pick % len(ways)] for name, ways in shared.items()}
            wanted = np.array([rhs(**{**one, **{name: many[name][k] for name in by_rows}}) for k in range(7)])
            for rows in (many, strided, {name: np.asfortranarray(a) for name, a in many.items()}):
                found = rhs(**one | {name: rows[name] for name in by_rows})
                assert found.tobytes() == wanted.tobytes()
            assert rhs(0.5, X, p, np.array([2.0])).tobytes() == rhs(0.5, X[None], p, np.array([2.0]))[0].tobytes()
    assert not careful


def test_many_rows(rhs, careful):
    """More numbers than are summed as squares: the same results, and what is not finite is found."""
    r = np.array([2.0])
    rows = np.tile(ROWS, (300, 1))
    assert rhs(0.5, rows, None, r).tobytes() == np.tile(rhs(0.5, ROWS, None, r), (300, 1)).tobytes()
    assert not careful
    for bad in (np.nan, np.inf):
        rows[1234, 2] = bad
        with pytest.raises(kn.ArgumentError, match=rf"Expected finite states, got .* = {bad} at \(1234,\)"):
            rhs(0.5, rows, None, r)
    rows[1235, 2] = -np.inf
    with pytest.raises(kn.ArgumentError, match="Expected finite states"):
        rhs(0.5, rows, None, r)


def test_rows_that_cannot_be_written_to_or_are_not_aligned(rhs):
    r = np.array([2.0])
    frozen, raw = ROWS.copy(), np.zeros(ROWS.nbytes + 1, np.uint8)
    frozen.flags.writeable = False
    odd = raw[1:].view(np.float64).reshape(ROWS.shape)
    odd[:] = ROWS
    assert not odd.flags.aligned
    for rows in (frozen, odd):
        assert rhs(0.5, rows, None, r).tobytes() == rhs(0.5, ROWS, None, r).tobytes()


def test_parameters_of_rows_do_not_stay(rhs):
    """What a batch hoists for its parameters is not what the next single call takes."""
    p, r = np.array(list(P.values())), np.array([2.0])
    wanted, other = rhs(0.0, X, p, r), rhs(0.0, X, 2 * p, r)
    rhs(0.0, X, p, r)
    for _ in range(3):
        assert rhs(0.0, np.tile(X, (3, 1)), 2 * p, r)[2].tobytes() == other.tobytes()
        assert rhs(0.0, X, p, r).tobytes() == wanted.tobytes()


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"x": np.ones((7, 3))}, "Expected x of shape"),
        ({"t": np.ones(6)}, "broadcast"),
        ({"p": np.ones((7, 2))}, "Expected p of shape"),
        ({"p": np.ones((6, len(P)))}, "broadcast"),
        ({"r": np.full((7, 1), np.nan)}, "Expected finite inputs"),
        ({"t": np.inf}, "Expected finite time"),
        ({"p": {EOM.parameters[0]: np.inf}}, "Expected finite parameters"),
        ({"t": 10**400}, "Expected real numbers as t"),
        ({"x": np.ones((7, 4), complex)}, "Expected real numbers as x"),
    ],
)
def test_rows_that_are_refused(rhs, given, message):
    rhs(0.0, X, {EOM.parameters[0]: 1.0}, {"F": 2.0})
    for _ in range(2):
        with pytest.raises(kn.ArgumentError, match=message):
            rhs(**{"t": 0.5, "x": ROWS, "p": None, "r": np.array([2.0])} | given)


def test_single_calls_at_times_that_are_whole_numbers(rhs, careful):
    r = np.array([2.0])
    assert rhs(1, X, None, r).tobytes() == rhs(1.0, X, None, r).tobytes()
    assert not careful
    with pytest.raises(kn.ArgumentError, match="Expected real numbers as t"):
        rhs(10**400, X, None, r)


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

# SPDX-License-Identifier: BSD-3-Clause
"""Handles as Python calls them: shapes, types, values that are missing or not finite, copies."""

import array
import pickle
import warnings

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import kane as kn
from kane.gallery import load
from kane.gallery.pendulums import system as chain
from kane.program import target

N = 3
EOM = kn.derive(chain(N))
COMPILED = EOM.compile()
RHS = COMPILED.rhs
P = COMPILED.parameters()


def state(seed=0, rows=()):
    return np.random.default_rng(seed).uniform(-1.5, 1.5, (*rows, 2 * N))


def reference(x, p=None, t=0.0):
    parameters = None if p is None else dict(zip(EOM.parameters, np.moveaxis(np.asarray(p), -1, 0), strict=True))
    q, u = np.moveaxis(np.asarray(x), -1, 0)[:N], np.moveaxis(np.asarray(x), -1, 0)[N:]
    found = EOM.evaluate(EOM.right_hand_side, q=list(q), u=list(u), parameters=parameters, t=t)
    return np.stack(np.broadcast_arrays(*found), axis=-1)


def close(a, b):
    return np.allclose(a, b, rtol=1e-12, atol=1e-12)


class TestShapes:
    def test_one_state(self):
        x = state()
        assert RHS(0.0, x).shape == (2 * N,)
        assert close(RHS(0.0, x), reference(x))

    @given(st.sampled_from([(), (1,), (4,), (2, 3), (0,), (1, 5)]), st.sampled_from([(), (1,), (4,), (2, 3), (2, 1)]))
    def test_leading_axes_broadcast(self, rows, others):
        try:
            shape = np.broadcast_shapes(rows, others)
        except ValueError:
            return
        x = state(1, rows)
        p = P * np.random.default_rng(2).uniform(0.5, 2, (*others, len(P)))
        found = RHS(0.0, x, p)
        assert found.shape == (*shape, 2 * N)
        assert close(found, reference(np.broadcast_to(x, (*shape, 2 * N)), np.broadcast_to(p, (*shape, len(P)))))

    def test_each_row_is_the_result_of_one_call(self):
        x = state(3, (5,))
        rows = RHS(0.0, x)
        assert all(np.array_equal(rows[k], RHS(0.0, x[k])) for k in range(5))

    def test_parameters_hoisted_anew_for_each_row(self):
        x, p = state(4), P * np.linspace(0.5, 2, 6)[:, None]
        assert all(np.array_equal(RHS(0.0, x, p)[k], RHS(0.0, x, p[k])) for k in range(6))

    def test_parameters_that_change_between_calls(self):
        x = state(5)
        first, p = RHS(0.0, x, P), P.copy()
        p[0] *= 3
        other = RHS(0.0, x, p)
        assert not np.array_equal(first, other)
        assert close(other, reference(x, p))
        p[0] = P[0]  # the same array with other contents
        assert np.array_equal(RHS(0.0, x, p), first)

    def test_sign_of_a_zero_parameter_is_a_change(self):
        (q,), (u,) = kn.coordinates("q"), kn.speeds("u")
        n = kn.Frame("N")
        o = kn.Point("O", fixed_in=n)
        m, c = kn.parameter("m", 1.0), kn.parameter("c", 0.0)
        load_ = kn.atan2(c, -1 * m) * n.x  # ±π, hoisted
        point = o.at("P", q * n.x)
        system = kn.System(n, bodies=[kn.Particle("P", point, m)], speeds={u: q.dt}, loads=[kn.Force(point, load_)])
        rhs = kn.derive(system).compile().rhs
        found = [rhs(0.0, np.zeros(2), np.array([1.0, c]))[1] for c in (0.0, -0.0, 0.0)]
        assert np.allclose(found, [np.pi, -np.pi, np.pi])

    def test_matrix(self):
        x = state(6, (4,))
        found = COMPILED.mass_matrix(0.0, x)
        assert found.shape == (4, N, N)
        u_dot = np.linalg.solve(found, COMPILED.forcing(0.0, x)[..., None])[..., 0]
        assert close(u_dot, RHS(0.0, x)[..., N:])

    def test_non_contiguous_arrays(self):
        wide = state(7, (6,))
        expected = reference(wide[2])
        assert close(RHS(0.0, np.asfortranarray(wide)[2]), expected)
        assert close(RHS(0.0, np.repeat(wide[2], 2)[::2]), expected)
        assert close(RHS(0.0, wide[2][::-1].copy()[::-1]), expected)
        assert close(RHS(0.0, wide[::2]), reference(wide[::2]))
        assert close(RHS(0.0, np.asfortranarray(wide)), reference(wide))

    @pytest.mark.parametrize("kind", [np.float32, np.int64, np.int8, np.bool_, ">f8", "<f4"])
    def test_other_real_types_are_converted(self, kind):
        x = np.array([0, 1, 0, 1, 1, 0]).astype(kind)
        assert close(RHS(0.0, x), reference(x.astype(float)))

    def test_sequences(self):
        x = list(state(8))
        assert close(RHS(0, x), reference(x))
        assert close(RHS(np.float64(0), tuple(x)), reference(x))
        assert close(RHS(np.array(0.0), array.array("d", x)), reference(x))

    def test_a_mapping_for_the_state(self):
        x = state(8)
        names = [s.name for s in (*EOM.coordinates, *EOM.speeds)]
        assert close(RHS(0.0, dict(zip(names, x, strict=True))), reference(x))
        with pytest.raises(kn.ValueMissingError, match=r"one of the states, got none for u3: pass them as x\.$"):
            RHS(0.0, dict(zip(names[:-1], x, strict=False)))

    def test_axes_of_the_time(self):
        x = state(8)
        for t in (np.zeros(1), [0.0], np.zeros((1, 1))):
            assert RHS(t, x).shape == (*np.shape(t), 6)
        assert RHS(np.array(0.0), x).shape == RHS(0, x).shape == (6,)

    def test_masked_array_without_masked_values(self):
        assert close(RHS(0.0, np.ma.array(state(8))), reference(state(8)))

    def test_read_only_arrays(self):
        x = state(9)
        x.flags.writeable = False
        assert close(RHS(0.0, x), reference(x))


class TestCopies:
    def test_results_are_never_shared(self):
        a, b = RHS(0.0, state(0)), None
        kept = a.copy()
        b = RHS(0.0, state(1))
        assert np.array_equal(a, kept)
        a[:] = 0
        assert np.array_equal(b, RHS(0.0, state(1)))

    def test_arguments_are_left_alone(self):
        x, p = state(2), P.copy()
        RHS(0.0, x, p)
        assert np.array_equal(x, state(2))
        assert np.array_equal(p, P)

    def test_solve_ivp_as_it_is(self):
        from scipy.integrate import solve_ivp

        start = np.array([0.3, 0.1, -0.2, 0.0, 0.0, 0.0])
        plain = solve_ivp(RHS, (0, 2), start, rtol=1e-10, atol=1e-10, method="DOP853")
        given_ = solve_ivp(RHS, (0, 2), start, rtol=1e-10, atol=1e-10, method="DOP853", args=(P,))
        sol = kn.simulate(EOM, (0, 2), q=start[:N], u=start[N:], rtol=1e-10, atol=1e-10)
        assert np.array_equal(plain.y, given_.y)
        assert np.allclose(plain.y[:, -1], sol.states[-1], atol=1e-8)

    def test_pickled_handle_gives_the_same(self):
        again = pickle.loads(pickle.dumps(RHS))
        assert np.array_equal(again(0.0, state(3)), RHS(0.0, state(3)))
        assert again.labels == RHS.labels


class TestNesting:
    def test_a_hook_that_calls_the_same_routine(self, monkeypatch):
        """A warning's hook runs inside the call that warns."""
        top = kn.derive(load("spinning_top").system())
        rhs = top.compile().rhs
        x = np.zeros(len(top.coordinates) + len(top.speeds))
        x[-1] = 5.0
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            expected = rhs(0.0, x)
        with warnings.catch_warnings():
            warnings.simplefilter("always")
            monkeypatch.setattr(warnings, "showwarning", lambda *_, **__: rhs(0.0, x + 0.5))
            assert np.array_equal(rhs(0.0, x), expected, equal_nan=True)

    def test_a_signal_that_calls_the_same_routine(self):
        import signal

        a, b = state(1), state(2)
        expected = RHS(0.0, a)

        armed = True

        def handler(*_):
            RHS(0.0, b)
            if armed:  # only now: a slow machine would nest without end
                signal.setitimer(signal.ITIMER_VIRTUAL, 1e-4)

        before = signal.signal(signal.SIGVTALRM, handler)
        signal.setitimer(signal.ITIMER_VIRTUAL, 1e-4)
        try:
            right = all(np.array_equal(RHS(0.0, a), expected) for _ in range(20_000))
        finally:
            armed = False
            signal.setitimer(signal.ITIMER_VIRTUAL, 0)
            signal.signal(signal.SIGVTALRM, before)
        assert right

    def test_the_warning_names_the_callers_line(self):
        top = kn.derive(load("spherical_pendulum").system())
        compiled = top.compile(outputs={"a": top.accelerations[0]})
        x = np.zeros(len(top.coordinates) + len(top.speeds))
        x[-1] = 5.0
        for call in (compiled.rhs, compiled.outputs, lambda t, x: compiled.rhs(t, np.stack([x, x]))):
            with pytest.warns(kn.KaneWarning) as caught:
                call(0.0, x)
            assert caught[0].filename == __file__


class TestWrong:
    @pytest.mark.parametrize(
        ("arguments", "message"),
        [
            (
                (0.0, np.zeros(5)),
                r"Expected x of shape \(…, 6\), got shape \(5,\). The order is q1, q2, q3, u1, u2, u3.",
            ),
            ((0.0, np.zeros((6, 5))), r"got shape \(6, 5\)"),
            ((0.0, 1.0), r"Expected x of shape \(…, 6\), got shape \(\)"),
            ((0.0, np.zeros(6), np.ones(3)), r"Expected p of shape \(…, 7\), got shape \(3,\). The order is "),
            ((0.0, np.zeros(6), None, [1.0]), r"Expected r of shape \(…, 0\), got shape \(1,\)"),
            ((0.0, np.zeros(6) * 1j), "Expected real numbers as x, got an array of complex128"),
            ((0.0, ["a"] * 6), "Expected real numbers as x, got list"),
            ((0.0, np.zeros(6, object)), "Expected real numbers as x, got an array of object"),
            ((0.0, None), "Expected real numbers as x, got NoneType"),
            ((0.0, [[1.0], [1.0, 2.0]]), "Expected real numbers as x, got list"),
            (("now", np.zeros(6)), "Expected real numbers as t, got str"),
            (
                (0.0, np.zeros((2, 6)), np.ones((3, 7))),
                r"leading axes that broadcast, got t \(\), x \(2, 6\), p \(3, 7\)",
            ),
        ],
    )
    def test_shapes_and_types(self, arguments, message):
        with pytest.raises(kn.ArgumentError, match=message):
            RHS(*arguments)

    @pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
    def test_values_that_are_not_finite(self, bad):
        x = state()
        x[4] = bad
        with pytest.raises(kn.ArgumentError, match=f"Expected finite states, got u2 = {bad}."):
            RHS(0.0, x)
        with pytest.raises(kn.ArgumentError, match=rf"got u2 = {bad} at \(1,\)"):
            RHS(0.0, np.stack([state(), x]))
        with pytest.raises(kn.ArgumentError, match=f"Expected finite time, got t = {bad}"):
            RHS(bad, state())
        with pytest.raises(kn.ArgumentError, match=f"Expected finite parameters, got {EOM.parameters[0]} = {bad}"):
            RHS(0.0, state(), np.array([bad, *P[1:]]))

    def test_a_value_that_no_result_depends_on_must_be_finite_too(self):
        (q,), (u,) = kn.coordinates("q"), kn.speeds("u")
        n = kn.Frame("N")
        o = kn.Point("O", fixed_in=n)
        m = kn.parameter("m", 1.0)
        eom = kn.derive(kn.System(n, bodies=[kn.Particle("P", o.at("P", q * n.x), m)], speeds={u: q.dt}))
        with pytest.raises(kn.ArgumentError, match="got q = nan"):
            eom.compile().rhs(0.0, np.array([np.nan, 1.0]))

    def test_parameters_by_name(self):
        x = state()
        expected = reference(x, [*P[:-1], 1.62])
        assert close(RHS(0.0, x, {"g": 1.62}), expected)
        assert close(RHS(0.0, x, {EOM.parameters[-1]: 1.62}), expected)
        assert close(RHS(0.0, x, {"g": np.array([1.62, 9.81])})[0], expected)
        with pytest.raises(
            kn.ValueMissingError, match=r"Expected values for parameters of the system .* got one for 'G'"
        ):
            RHS(0.0, x, {"G": 1.62})
        with pytest.raises(kn.ArgumentError, match="whose shapes broadcast"):
            RHS(0.0, x, {"g": np.ones(2), "m1": np.ones(3)})

    def test_division_by_zero_is_named(self):
        top = kn.derive(load("spherical_pendulum").system())
        names = [s.name for s in (*top.coordinates, *top.speeds)]
        x = np.zeros(len(names))
        x[-1] = 5.0
        handle = top.compile().rhs
        text = r"Expected finite results of rhs, got .* = (inf|nan) where .*; it makes .* not finite"
        with pytest.warns(kn.KaneWarning, match=text):
            assert not np.isfinite(handle(0.0, x)).all()
        with pytest.warns(kn.KaneWarning, match=r"rhs at \(1,\), got"):
            handle(0.0, np.stack([x + 0.5, x]))
        with pytest.raises(kn.NotFiniteError, match=text):
            top.compile(not_finite="raise").rhs(0.0, x)
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            assert not np.isfinite(top.compile(not_finite="ignore").rhs(0.0, x)).all()
        assert "not finite" in handle.explain(0.0, x)
        assert handle.explain(0.0, x + 0.5) == ""

    def test_nan_that_only_contraction_gives_says_so(self):
        (q,), (u,) = kn.coordinates("q"), kn.speeds("u")
        n = kn.Frame("N")
        o = kn.Point("O", fixed_in=n)
        point = o.at("P", q * n.x)
        force = kn.Force(point, kn.sqrt(q * q - u * u) * n.x)
        eom = kn.derive(kn.System(n, bodies=[kn.Particle("P", point, 1)], speeds={u: q.dt}, loads=[force]))
        x = np.repeat(np.random.default_rng(0).uniform(1, 2, (50, 1)), 2, axis=1)
        assert np.array_equal(eom.compile(contract=False).rhs(0.0, x)[:, 1], np.zeros(50))
        if "+fma" not in target().features:  # nothing contracts
            assert np.array_equal(eom.compile().rhs(0.0, x)[:, 1], np.zeros(50))
            return
        with pytest.warns(kn.KaneWarning, match=r"Use compile\(contract=False\)"):
            assert np.isnan(eom.compile().rhs(0.0, x)).any()

    def test_explaining_takes_one_state(self):
        with pytest.raises(kn.ArgumentError, match=r"Expected one state to explain, got shapes \(\), \(2, 6\)"):
            RHS.explain(0.0, np.zeros((2, 6)))
        with pytest.raises(kn.ArgumentError, match="Expected real numbers as t, got str"):
            RHS.explain("a", np.zeros(6))

    def test_what_to_do_must_be_known(self):
        with pytest.raises(
            kn.ArgumentError, match='Expected not_finite to be "warn", "raise" or "ignore", got \'stop\''
        ):
            EOM.compile(not_finite="stop")


class TestMissing:
    def setup_method(self):
        (q,), (u,) = kn.coordinates("q"), kn.speeds("u")
        n = kn.Frame("N")
        o = kn.Point("O", fixed_in=n)
        m, f = kn.parameter("m"), kn.input("F")
        point = o.at("P", q * n.x)
        system = kn.System(n, bodies=[kn.Particle("P", point, m)], speeds={u: q.dt}, loads=[kn.Force(point, f * n.x)])
        self.eom = kn.derive(system)

    def test_parameter_without_a_default(self):
        rhs = self.eom.compile().rhs
        with pytest.raises(
            kn.ValueMissingError, match="one of the parameters, got none for m: pass them as p, or declare"
        ):
            rhs(0.0, np.zeros(2), None, np.ones(1))
        with pytest.raises(kn.ValueMissingError, match="got none for m"):
            rhs(0.0, np.zeros((3, 2)), None, np.ones(1))
        assert np.array_equal(rhs(0.0, np.zeros(2), np.array([2.0]), np.array([3.0])), [0, 1.5])

    def test_default_given_when_compiling(self):
        compiled = self.eom.compile(parameters={"m": 2.0})
        assert np.array_equal(compiled.rhs(0.0, np.zeros(2), None, np.array([3.0])), [0, 1.5])
        assert np.array_equal(compiled.parameters(), [2.0])
        with pytest.raises(kn.ValueMissingError, match="got one for 'mass'"):
            self.eom.compile(parameters={"mass": 2.0})
        with pytest.raises(kn.SimulationError, match="Expected a finite value for m, got nan"):
            self.eom.compile(parameters={"m": np.nan})

    def test_inputs(self):
        rhs = self.eom.compile(parameters={"m": 2.0}).rhs
        with pytest.raises(kn.ValueMissingError, match=r"inputs, got none for F: pass them as r, {'F': value}."):
            rhs(0.0, np.zeros(2))
        assert np.array_equal(rhs(0.0, np.zeros(2), None, {"F": 3.0}), [0, 1.5])
        assert np.array_equal(rhs(0.0, np.zeros(2), None, np.array([[3.0], [4.0]])), [[0, 1.5], [0, 2]])
        with pytest.raises(kn.ArgumentError, match="Expected finite inputs, got F = inf"):
            rhs(0.0, np.zeros(2), None, np.array([np.inf]))


class TestCompiled:
    def test_outputs(self):
        tip = EOM.system["P2"]
        origin = EOM.system["O"]
        compiled = EOM.compile(
            outputs={
                "energy": EOM.energy,
                "tip": tip.position(origin),
                "M": EOM.mass_matrix,
                "pair": [EOM.coordinates[0], 2],
            }
        )
        x = state(1, (4,))
        found = compiled.outputs(0.0, x)
        assert {k: v.shape for k, v in found.items()} == {"energy": (4,), "tip": (4, 3), "M": (4, N, N), "pair": (4, 2)}
        assert close(found["M"], compiled.mass_matrix(0.0, x))
        assert close(found["pair"][:, 0], x[:, 0])
        sol_energy = EOM.evaluate(EOM.energy, q=list(x.T[:N]), u=list(x.T[N:]))
        assert close(found["energy"], sol_energy)
        one = compiled.outputs(0.0, x[0])
        assert {k: v.shape for k, v in one.items()} == {"energy": (), "tip": (3,), "M": (N, N), "pair": (2,)}
        assert all(close(one[k], found[k][0]) for k in one)

    @pytest.mark.parametrize(
        ("outputs", "error", "message"),
        [
            ({"E": "K"}, kn.ValueMissingError, "got 'K'"),
            ({"E": {1}}, kn.ArgumentError, "a list of these as output 'E', got {1}"),
            ({1: EOM.energy}, kn.ArgumentError, "Expected a name for every output, got 1"),
            (
                [EOM.energy],
                kn.ArgumentError,
                "Expected outputs as a mapping from names to expressions, or a list of symbols and names, got list",
            ),
            (
                {"c": kn.parameter("c")},
                kn.ValueMissingError,
                r"Expected the output 'c' in symbols of the system, got c \(Param",
            ),
        ],
    )
    def test_wrong_outputs(self, outputs, error, message):
        with pytest.raises(error, match=message):
            EOM.compile(outputs=outputs)

    def test_no_outputs(self):
        with pytest.raises(kn.ArgumentError, match="Expected outputs to have been named"):
            COMPILED.outputs(0.0, state())
        with pytest.raises(
            kn.ArgumentError,
            match=r"Expected routines among rhs, mass_matrix, forcing, reactions, .*jac.*, got 'outputs'",
        ):
            COMPILED.emit("c", ["outputs"])
        assert COMPILED.emit("c", "rhs") == COMPILED.emit("c", ["rhs"])

    def test_what_cannot_be_compiled_or_copied(self):
        with pytest.raises(kn.ArgumentError, match="Expected Equations, got System: derive them first"):
            kn.compile(EOM.system)
        with pytest.raises(kn.ArgumentError, match="Expected a text as name, got 3"):
            EOM.compile(name=3)
        with pytest.raises(kn.ArgumentError, match=r"Expected a routine to pickle or copy, compiled\.rhs"):
            pickle.dumps(COMPILED)
        with pytest.raises(KeyError, match="Expected one of rhs, mass_matrix, forcing, reactions, got 'energy'"):
            COMPILED.operations["energy"]

    def test_a_parameter_may_be_called_as_the_time_is(self):
        (q,), (u,) = kn.coordinates("q"), kn.speeds("u")
        n = kn.Frame("N")
        o = kn.Point("O", fixed_in=n)
        t = kn.parameter("t", 2.0, "kg", "the mass")
        system = kn.System(n, bodies=[kn.Particle("P", o.at("P", q * n.x), t)], speeds={u: q.dt})
        eom = kn.derive(system)
        assert np.array_equal(eom.compile().rhs(0.0, np.array([1.0, 3.0])), [3, 0])
        assert kn.simulate(eom, (0, 1), q=[0], u=[1]).q[-1] == pytest.approx(1)

    def test_reactions(self):
        eom = kn.derive(load("rolling_disk").model().system)
        compiled = eom.compile()
        x = np.array([0.1, 0.2, 0.0, 0.0, 0.0, 0.3, 2.0, 20.0, 2.0, 0.4])
        expected = eom.evaluate(eom.reaction_values, q=x[:5], u=x[5:])
        assert close(compiled.reactions(0.0, x), expected)
        assert compiled.reactions.labels == tuple(r.name for r in eom.reactions)
        residual = compiled.mass_matrix(0.0, x) @ compiled.rhs(0.0, x)[5:] - compiled.forcing(0.0, x)
        assert np.abs(residual).max() < 1e-11

    def test_no_reactions(self):
        assert COMPILED.reactions(0.0, state()).shape == (0,)
        assert COMPILED.reactions(0.0, state(0, (3,))).shape == (3, 0)

    def test_receipt(self):
        receipt = COMPILED.operations
        assert [name for name, _ in receipt.routines] == ["rhs", "mass_matrix", "forcing", "reactions"]
        plain = EOM.compile(contract=False).operations["rhs"]
        assert (plain.state, plain.parameter) == (EOM.operations.state, EOM.operations.parameter)

    def test_contraction_and_generic_processor_change_roundings_only(self):
        x = state(2, (20,))
        expected = reference(x)
        for options in ({}, {"contract": False}, {"cpu": "generic"}, {"cpu": "generic", "contract": False}):
            assert close(EOM.compile(**options).rhs(0.0, x), expected)
        exact = [EOM.compile(contract=False, cpu=cpu).rhs(0.0, x) for cpu in ("host", "generic")]
        assert np.array_equal(*exact)

    def test_other_processor(self):
        with pytest.raises(kn.ProgramError, match=r'Expected cpu to be "host", "generic" or .*, got \'cray1\''):
            EOM.compile(cpu="cray1")

    def test_repr(self):
        assert repr(COMPILED) == "Compiled('model': <rhs(t, x[6], p[7]) -> [6]: q1', q2', q3', u1', u2', u3'>)"

    def test_unknown_target(self):
        with pytest.raises(kn.ArgumentError, match=r"Expected one of c, h, numpy, .*wasm, got 'fortran'"):
            COMPILED.emit("fortran")


class TestWithoutParameters:
    """Reciprocals of constants are hoisted too: they are there from the first call on, with no parameter that changes."""

    def body(self):
        """Euler's equations of a free body: ω̇₁ = (I₂ − I₃)/I₁ ω₂ ω₃ and so on."""
        frame = kn.Frame("N")
        origin = kn.Point("O", fixed_in=frame)
        free = kn.ball("B", origin, frame, orientation="angles")
        inertia = kn.inertia(free.frame, 0.3, 0.4, 0.5)
        body = kn.RigidBody("b", frame=free.frame, mass_center=free.point, mass=2, inertia=inertia)
        return kn.derive(kn.System(frame, bodies=[body], joints=[free]))

    def test_one_call_and_many(self):
        eom = self.body()
        handle = eom.compile().rhs
        w = np.array([0.3, 0.2, -0.5])
        expected = [(0.4 - 0.5) / 0.3 * w[1] * w[2], (0.5 - 0.3) / 0.4 * w[2] * w[0], (0.3 - 0.4) / 0.5 * w[0] * w[1]]
        x = np.array([0.2, 0.4, -0.3, *w])
        assert not eom.parameters
        for found in (handle(0.0, x), handle(0.0, x), handle(0.0, x, np.zeros(0)), *handle(0.0, np.stack([x, x]))):
            assert close(found[3:], expected)

    def test_the_motion_keeps_its_energy(self):
        sol = kn.simulate(self.body(), (0, 2), q=[0.2, 0.4, -0.3], u=[1.3, 0.2, -1.5], rtol=1e-10, atol=1e-10)
        assert sol.energy_check.relative < 1e-8

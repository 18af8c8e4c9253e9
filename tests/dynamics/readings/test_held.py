# SPDX-License-Identifier: BSD-3-Clause
"""Speeds at a state: independent ones suffice, those that miss the constraints are named."""

import numpy as np
import pytest

import kane as kn
from kane.gallery import load
from tests.systems.four_bar import BAR, EOM, state

STATE = state()
OWN = {EOM.independent_speeds[0]: STATE["u"][EOM.independent_speeds[0]]}
ASKED = {
    "accelerations": list(EOM.accelerations),
    "energy": EOM.energy,
    "a multiplier": EOM.multipliers[BAR.close[0]],
    "speeds": list(EOM.speeds),
    "forcing": list(EOM.forcing),
}


@pytest.mark.parametrize("what", ASKED)
def test_independent_speeds_alone_are_as_good_as_all(what):
    every, own = EOM.evaluate(ASKED[what], **STATE), EOM.evaluate(ASKED[what], q=STATE["q"], u=OWN)
    assert np.array(own) == pytest.approx(np.array(every), rel=1e-12, abs=1e-12)


@pytest.mark.parametrize("name", ["pure_rolling_disk", "knife_edge", "chaplygin_sleigh", "rattleback"])
def test_rolling_and_sliding_with_independent_speeds_alone(name, rng):
    eom = kn.derive(load(name).system())
    start = dict(zip(eom.coordinates, rng.uniform(0.1, 0.4, len(eom.coordinates)), strict=True))
    own = dict(zip(eom.independent_speeds, rng.normal(size=len(eom.independent_speeds)), strict=True))
    at = kn.assemble(eom, q=start, u=own)
    found = [eom.evaluate(list(eom.right_hand_side), q=at.q, u=u) for u in (own, at.u)]
    assert np.array(found[0]) == pytest.approx(np.array(found[1]), rel=1e-9, abs=1e-9)
    for d in eom.dependent_speeds:
        if at.u[d]:
            with pytest.raises(kn.SimulationError, match="satisfy the constraints"):
                eom.evaluate(eom.kinetic_energy, q=at.q, u=at.u | {d: 1.001 * at.u[d]})


def test_arrays_of_independent_speeds():
    own = EOM.independent_speeds[0]
    many = EOM.evaluate(EOM.energy, q=STATE["q"], u={own: np.array([1.0, 2.0])})
    assert many[1] - many[0] == pytest.approx(
        3 * EOM.evaluate(EOM.kinetic_energy, q=STATE["q"], u={own: 1.0}), rel=1e-12
    )


def off(by):
    """The state with one dependent speed off."""
    return STATE | {"u": STATE["u"] | {EOM.dependent_speeds[0]: STATE["u"][EOM.dependent_speeds[0]] + by}}


@pytest.mark.parametrize("what", ["accelerations", "energy", "speeds"])
def test_speeds_off_the_constraints_are_named(what):
    cure = f"independent speeds alone, u= of {EOM.independent_speeds[0].name}: the others follow"
    with pytest.raises(
        kn.SimulationError, match=rf"satisfy the constraints A u \+ b = 0, got some that miss 'close .*{cure}"
    ):
        EOM.evaluate(ASKED[what], **off(0.1))


def test_what_holds_no_speeds_asks_nothing_of_them():
    assert np.all(EOM.evaluate(EOM.mass_matrix, **off(1.0)) == EOM.evaluate(EOM.mass_matrix, q=STATE["q"]))


@pytest.mark.parametrize("size", [1e-9, 1.0, 1e9])
def test_the_tolerance_is_a_share_of_the_terms(size):
    u = {s: size * v for s, v in STATE["u"].items()}
    first = EOM.dependent_speeds[0]
    EOM.evaluate(EOM.energy, q=STATE["q"], u=u | {first: u[first] * (1 + 1e-8)})
    with pytest.raises(kn.SimulationError, match="miss 'close"):
        EOM.evaluate(EOM.energy, q=STATE["q"], u=u | {first: u[first] * (1 + 1e-4)})


def test_of_arrays_a_warning_names_the_first_place():
    first = EOM.dependent_speeds[0]
    u = STATE["u"] | {first: STATE["u"][first] + np.array([0.0, 0.1, 0.0, 0.2])}
    with pytest.warns(kn.KaneWarning, match=r"at every state, got some that miss 'close .* at index 1, and at 1 more"):
        values = EOM.evaluate(EOM.kinetic_energy, q=STATE["q"], u=u)
    assert values[0] == pytest.approx(EOM.evaluate(EOM.kinetic_energy, **STATE), rel=1e-12)


def test_one_dependent_speed_given_and_the_other_left_out():
    first, second = EOM.dependent_speeds
    given = OWN | {first: STATE["u"][first]}
    assert EOM.evaluate(second, q=STATE["q"], u=given) == pytest.approx(STATE["u"][second], rel=1e-12)
    with pytest.raises(kn.SimulationError, match="miss 'close"):
        EOM.evaluate(second, q=STATE["q"], u=given | {first: 3.3})


def test_an_independent_speed_left_out_is_named():
    with pytest.raises(kn.ValueMissingError, match=f"got none for {EOM.independent_speeds[0].name} .Speed."):
        EOM.evaluate(EOM.energy, q=STATE["q"], u={EOM.dependent_speeds[0]: 1.0})


@pytest.mark.parametrize("angle", [0.0, np.pi / 2, np.pi, 1.0])
def test_what_rounding_leaves_is_no_miss(angle):
    """A bead on a stick at x, y = cos, sin of an angle: one entry of A is 6e-17 where the stick is upright or level."""
    N = kn.Frame("N")
    o = kn.Point("o", fixed_in=N)
    x, y = kn.coordinates("x y")
    bead = kn.Particle("bead", o.at("bead", x * N.x + y * N.y), 1)
    stick = kn.distance(bead.point, o, 1, name="stick")
    for dependent in kn.speeds("u_x u_y"):
        eom = kn.derive(kn.System(N, bodies=[bead], speeds="rates", holonomic=stick, dependent_speeds=[dependent]))
        c, s = np.cos(angle), np.sin(angle)
        exact = {0.0: (0.0, 2.0), np.pi / 2: (-2.0, 0.0), np.pi: (0.0, -2.0)}.get(angle, (-2 * s, 2 * c))
        assert eom.evaluate(eom.kinetic_energy, q=[c, s], u=exact) == pytest.approx(2.0)
        with pytest.raises(kn.SimulationError, match="miss 'stick' by"):
            eom.evaluate(eom.kinetic_energy, q=[c, s], u=[exact[0] + 0.1 * c, exact[1] + 0.1 * s])


def test_a_drive_at_rest_for_an_instant():
    """b = v cos(ω t) is 6e-17 v where ω t = π/2: speeds that are zero hold there, and at t = 0 they do not."""
    N = kn.Frame("N")
    x = kn.coordinate("x")
    u = kn.speed("u")
    p = kn.Particle("p", kn.Point("o", fixed_in=N).at("p", x * N.x), 1)
    driven = x.dt - 3 * kn.cos(2 * kn.time)
    eom = kn.derive(kn.System(N, bodies=[p], speeds={u: x.dt}, nonholonomic=[driven]))
    assert eom.evaluate(eom.kinetic_energy, q=[0.1], u=[0.0], t=np.pi / 4) == 0
    assert eom.evaluate(u, q=[0.1]) == 3
    with pytest.raises(kn.SimulationError, match=r"by -3\. The constraints determine all speeds: leave them out"):
        eom.evaluate(eom.kinetic_energy, q=[0.1], u=[0.0])


def test_inverse_dynamics_at_independent_speeds():
    eom = BAR.derive(reactions=[kn.reaction("R", at=BAR.pivot, along=kn.Vector() + BAR.frames[0].x)])
    inverse = kn.inverse(eom, list(eom.reactions) + [u.dt for u in eom.speeds])
    every, own = inverse(q=STATE["q"], u=STATE["u"]), inverse(q=STATE["q"], u=OWN)
    assert list(own.values()) == pytest.approx(list(every.values()), rel=1e-9)
    with pytest.raises(kn.SimulationError, match="miss 'close"):
        inverse(**off(0.1))


def test_a_motion_is_read_where_its_samples_are():
    """Samples are on the constraints as far as the steps keep them: nothing is said of the rest."""
    sol = kn.simulate(EOM, (0, 0.5), **STATE, rtol=1e-5, atol=1e-5, samples=5)
    assert sol.energy_check.relative < 1e-3
    assert len(EOM.evaluate(EOM.energy, q=list(sol.q.T), u=list(sol.u.T))) == 5

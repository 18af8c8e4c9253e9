# SPDX-License-Identifier: BSD-3-Clause
"""The energy check is local: no spike on the way hides what is wrong after it, no rest on the way makes much of rounding."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import kane as kn
from kane.motion import energy_check, taken

N = kn.Frame("N")
O = kn.Point("O", fixed_in=N)
T = np.linspace(0, 10, 501)


def checked(kinetic, drift, potential=0.0, work=0.0, open_=0.0):
    """The check of K, V and ∫P dt, with `drift` more energy than they say: all functions of time."""
    k, d, v, w, o = (
        np.broadcast_to(x(T) if callable(x) else x, T.shape) for x in (kinetic, drift, potential, work, open_)
    )
    return energy_check(T, k, k + v + w + d, w, o)


@pytest.mark.parametrize("height", [1.0, 1e3, 1e9, 1e12])
@pytest.mark.parametrize("width", [0.02, 0.3])
def test_a_spike_hides_nothing(height, width):
    """K is about 1 but for a spike of any height; 5 % of 1 is gone after it."""

    def spike(t):
        return height * np.exp(-(((t - 5) / width) ** 2))

    check = checked(lambda t: 1 + spike(t), lambda t: 0.05 * (t > 5), lambda t: -spike(t))
    assert check.relative == pytest.approx(0.05, rel=0.1)
    assert check.scale >= height
    assert check.at > 5


@pytest.mark.parametrize("cycles", [0.1, 0.5, 3, 40])
def test_rests_on_the_way_are_no_small_scales(cycles):
    """K of a swing vanishes where it turns: a drift of 1e-8 of the swing's energy stays of that order."""

    def kinetic(t):
        return np.sin(2 * np.pi * cycles * t / 10) ** 2

    check = checked(kinetic, lambda t: 1e-8 * (t > 2), lambda t: 1 - kinetic(t))
    assert 1e-8 < check.relative < 1e-6


@pytest.mark.parametrize("factor", [1e-6, 1.0, 1e6])
def test_units_of_energy_do_not_matter(factor):
    check = checked(lambda t: factor * t**2, lambda t: factor * 1e-5 * t, open_=factor)
    assert check.relative == pytest.approx(checked(lambda t: t**2, lambda t: 1e-5 * t, open_=1.0).relative)


def test_rounding_of_a_large_potential_is_no_drift():
    """1e9 J of height, of which a swing of 1e-6 J changes nothing: what rounding leaves does not count."""
    check = checked(lambda t: 1e-6 * np.sin(t) ** 2, lambda t: 1e-7 * np.sin(9 * t), 1e9)
    assert check.relative == 0


def kepler(eccentricity, rtol, method="DOP853"):
    """From the far end of an ellipse of semi-axis 1 round and round."""
    x, y = kn.coordinates("x y")
    p = O.at("p", x * N.x + y * N.y)
    r = p.position(O)
    pull = kn.Load("pull", forces=((p, -r / r.magnitude() ** 3),), potential=-1 / r.magnitude())
    eom = kn.derive(kn.System(N, bodies=[kn.Particle("p", p, 1)], speeds="rates", loads=[pull]))
    start = {"q": [1 + eccentricity, 0], "u": [0, np.sqrt((1 - eccentricity) / (1 + eccentricity))]}
    return kn.simulate(eom, (0, 10), rtol=rtol, atol=rtol, method=method, samples=201, **start)


def test_an_orbit_that_all_but_collides():
    """The period follows from the energy: what the check says of the energy is what the orbit is off by."""
    with pytest.warns(kn.KaneWarning, match="unreliable from about there on"):
        sol = kepler(0.99999, 1e-6)
    energy = sol.energy
    assert sol.status == "finished"
    assert sol.energy_check.relative > 0.1 * abs(energy[-1] / energy[0] - 1) > 1e-3
    assert kepler(0.5, 1e-9).energy_check.relative < 1e-7


def test_what_dampers_take():
    """Their power is below zero at every sample; that of springs and drives is not, and few samples tell nothing."""
    damper, spring = -2 * np.sin(T) ** 2, np.sin(2 * T)
    found = taken(T, [damper, spring, np.full_like(T, np.nan), np.zeros_like(T)])
    np.testing.assert_allclose(found, T - np.sin(2 * T) / 2, atol=1e-3)
    assert not taken(T[:19], [damper[:19]]).any()
    assert not taken(T, []).any()


def test_what_dampers_take_hides_no_jump():
    """A thousand times what there is has been taken: D may have added up to more, but not at once."""
    steady = checked(1.0, lambda t: 1e-5 * t)
    given = T, np.ones_like(T), 1 + 1e-5 * T, 0 * T, 0 * T
    assert energy_check(*given, [np.full_like(T, -1e2)]).relative == pytest.approx(1e-5)
    assert steady.relative == pytest.approx(1e-4)
    jumps = T, np.ones_like(T), 1 + 1e-4 * (T > 5), 0 * T, 0 * T
    assert energy_check(*jumps, [np.full_like(T, -1e2)]).relative == pytest.approx(1e-4)


def test_work_that_is_taken_again_is_a_scale_of_its_error():
    """1 J is given and taken again: 1e-8 J is left of both, and no energy. What jumps later is measured by what there is then."""

    def given(t):
        return np.exp(-((t - 3) ** 2))

    def measured(when):
        return checked(given, lambda t: 1e-8 * (t > when), lambda t: -given(t), given).relative

    assert measured(3) == pytest.approx(1e-6, rel=0.1)
    assert measured(9) > 50 * measured(3)


def test_a_long_motion_whose_dampers_forget():
    """A forced oscillation for 2.2e5 s, right to 1e-9: what adds up in the work is no warning, what is wrong in the state is one."""
    x, v = kn.coordinate("x"), kn.speed("v")
    p = O.at("p", x * N.x)
    loads = [
        kn.Force(p, kn.cos(1.3 * kn.time) * N.x),
        kn.Force(p, -x * N.x),
        kn.Force(p, -0.1 * v * N.x),
    ]
    eom = kn.derive(kn.System(N, bodies=[kn.Particle("p", p, 1)], speeds={v: x.dt}, loads=loads))
    c = 1 / (1 - 1.3**2 + 0.13j)
    sol = kn.simulate(eom, (0, 2.2e5), q=[c.real], u=[-1.3 * c.imag], method="gauss16")
    np.testing.assert_allclose(sol["x"], (c * np.exp(1.3j * sol.t)).real, atol=1e-9)
    assert sol.energy_check.drift > 1e-5 * 2  # J of 2 J
    assert sol.keeps_energy
    for wrong in (1e-4, 1e-3):
        bent = replace(sol, states=sol.states * np.where(sol.t > 1.1e5, 1 + wrong, 1.0)[:, None])
        assert not bent.keeps_energy

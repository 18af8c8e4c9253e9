# SPDX-License-Identifier: BSD-3-Clause
"""Beams that shear, and whose sections turn with inertia: statics, sections, and what is refused."""

import pickle
from typing import Any

import numpy as np
import pytest

import kane as kn
from kane.dynamics import WAYS
from tests.systems.beams import spinning

SHEAR = {"shear": 40.0, "rotary": 0.01}


def test_static_deflection() -> None:
    """P L³/(3 EI) + P L/(k_s G A), sections turned by P L²/(2 EI): ξ², ξ³ and ξ have it exactly."""
    shapes = {"modes": kn.mode_shapes("legendre", 2), "shear_modes": kn.mode_shapes("legendre rod", 1)}
    beam, system = spinning(EI=3.0, length=2.0, **shapes, **SHEAR)
    tip, P = beam.point_at(1), kn.parameter("P", 1e-6, "N")
    eom = kn.derive(system.replace(loads=[kn.Force(tip, P * beam.frame.y)]))
    point = kn.trim(eom, q={q: kn.guess(0.0) for q in eom.coordinates}, u=dict.fromkeys(eom.speeds, 0.0))
    wanted = [tip.position(beam.root).dot(beam.frame.y), beam.frame_at(1).x.dot(beam.frame.y)]
    found = np.array(eom.evaluate(wanted, **point.arguments)) / 1e-6
    np.testing.assert_allclose(found, [8 / 9 + 2 / 40, 4 / 6], rtol=1e-9)


def test_coordinates_and_parameters() -> None:
    beam, system = spinning(EI=(1.0, 2.0), modes=(2, 1), shear=(40.0, 50.0), shear_modes=(1, 2), rotary=(0.01, 0.02))
    assert [q.name for q in beam.coordinates] == ["g1_beam", "h1_beam", "h2_beam", "v1_beam", "v2_beam", "w1_beam"]
    named = {p.name: p.default for p in system.parameters}
    assert named["kGAv_beam"] == 40.0
    assert named["rhoIw_beam"] == 0.02
    assert {name for name, _ in beam.measures()} >= {"shear", "EI"}
    assert repr(pickle.loads(pickle.dumps(beam))) == repr(beam)


@pytest.mark.parametrize("form", ["linearized", "nonlinear"])
def test_by_all_routes(form: str) -> None:
    _, system = spinning(
        modes=2, shear_modes=2, **SHEAR, form=form, angle=kn.sin(kn.parameter("w", 2.0, "rad/s") * kn.time)
    )
    eoms = [kn.derive(system, route=route) for route in ("classical", *WAYS)]
    state: dict[str, Any] = {"q": [0.05, -0.02, 0.1, 0.03], "u": [0.3, 0.2, -0.4, 0.1], "t": 0.3}
    values = [np.array(eom.evaluate([u.dt for u in eom.speeds], **state)) for eom in eoms]
    for other in values[1:]:
        np.testing.assert_allclose(other, values[0], rtol=1e-9)


def test_a_free_beam_keeps_its_angular_momentum() -> None:
    N = kn.Frame("N")
    base = kn.planar("base", kn.Point("O", fixed_in=N), N, normal=N.z)
    A = base.frame
    more = {"modes": 2, "shear_modes": kn.mode_shapes("rod", 2), **SHEAR}
    beam = kn.Beam("beam", base.point, frame=A, axis=A.x, length=1.0, mass_per_length=1.0, EI=1.0, **more)
    eom = kn.derive(kn.System(N, bodies=[beam], joints=[base]))
    start = {"q": [0.0, 0.0, 0.1, 0.001, 0.0, 0.02, 0.001], "u": [0.1, 0.2, 0.5, 0.0, 0.3, 0.0, -0.2]}
    sol = kn.simulate(eom, (0, 2), samples=21, rtol=1e-10, atol=1e-12, **start)
    turning = sol[eom.central_angular_momentum.dot(N.z)]
    assert np.ptp(turning) < 1e-9 * np.abs(turning).max()
    assert np.ptp(sol.energy) < 1e-9 * np.abs(sol.energy).max()


def test_functions_that_would_lock_the_root(rng: np.random.Generator) -> None:
    """Polynomials without a slope at the root are refused, however they are mixed; with one that has a slope they are not."""
    for count in (1, 2, 5):
        mixed = rng.normal(size=(count, count))
        flat = [lambda x, row=row: sum(c * x ** (k + 2) for k, c in enumerate(row)) for row in mixed]
        with pytest.raises(kn.ModelError, match="slopes do not all vanish at the root"):
            spinning(modes=1, **SHEAR, shear_modes=flat)
        spinning(modes=1, **SHEAR, shear_modes=[*flat, lambda x: x])
        spinning(modes=1, **SHEAR, shear_modes=kn.mode_shapes("rod polynomials", count))


@pytest.mark.parametrize(
    ("more", "text"),
    [
        ({"shear": 40.0}, "Expected rotary=moment of inertia of a section per length of beam, which shears, got none"),
        ({"shear_modes": 2}, "Expected k_s G A of beam as its shear=, got only functions"),
        ({"shear": -1.0, "rotary": 0.1}, "Expected shear of beam above zero, got -1"),
        ({"shear": 1.0, "rotary": 0.0}, "Expected rotary of beam above zero, got 0"),
        ({"shear": (1.0, 2.0), "rotary": 0.1}, "Expected one shear= of beam, which bends along one direction, got two"),
        ({"rotary": (1.0, 2.0)}, "Expected one rotary= of beam, which bends along one direction, got two"),
        (
            {**SHEAR, "shear_modes": kn.mode_shapes("free-free", 1)},
            "Expected functions of the shear of beam that are zero at the root",
        ),
        (
            {**SHEAR, "shear_modes": kn.mode_shapes("polynomials", 4)},
            r'do not all vanish at the root, which is constrained, got polynomials.* Use kn.mode_shapes\("rod polynomials", 4\)',
        ),
        (
            {**SHEAR, "support": "pinned", "shear_modes": kn.mode_shapes([lambda x: x * (1 - x) ** 2])},
            r'do not all vanish at the tip, which is constrained, got own functions.* Use kn.mode_shapes\("pinned", 1\)',
        ),
        ({**SHEAR, "damping": {"ratio": 0.1}}, r"Expected damping= of beam, which shears, as \{\"stiffness\": β\}"),
        ({**SHEAR, "shear_modes": "rod"}, "Expected shear_modes= of beam as a number of functions, rod polynomials"),
    ],
)
def test_bad_input(more: dict[str, Any], text: str) -> None:
    with pytest.raises(kn.ModelError, match=text):
        spinning(modes=1, **more)

# SPDX-License-Identifier: BSD-3-Clause
"""Beams: what they hold, and what they refuse."""

from __future__ import annotations

import pickle
from typing import Any

import numpy as np
import pytest
from scipy.integrate import quad

import kane as kn
from kane.errors import ModelError
from tests.systems.beams import spinning

N = kn.Frame("N")
O = kn.Point("O", fixed_in=N)
USUAL: dict[str, Any] = {"frame": N, "axis": N.x, "length": 2.0, "mass_per_length": 3.0, "EI": 5.0}


def beam(**changes: Any) -> Any:
    return kn.Beam("arm", O, **(USUAL | changes))


def test_coordinates_and_speeds() -> None:
    b = beam(modes=2, EA=7.0, stretch=1)
    assert [q.name for q in b.coordinates] == ["s1_arm", "v1_arm", "v2_arm"]
    assert [str(u) for u in b.speeds] == ["u_s1_arm", "u_v1_arm", "u_v2_arm"]
    assert repr(b) == "Beam('arm', from O in N; 1 of s, 2 of v)"


def test_a_beam_in_space() -> None:
    b = beam(EI=(5.0, 6.0), modes=(2, 1), GJ=2.0, polar=0.1)
    assert [q.name for q in b.coordinates] == ["v1_arm", "v2_arm", "w1_arm", "t1_arm"]


@pytest.mark.parametrize("form", ["linearized", "nonlinear"])
def test_mass_and_mass_centre(form: str) -> None:
    """All parts together weigh ρA L, half way along the straight beam."""
    system = kn.System(N, bodies=[beam(form=form)])
    eom = kn.derive(system)
    rest = {"q": dict.fromkeys(system.coordinates, 0.0), "u": dict.fromkeys(system.speeds, 0.0)}
    mass = sum((p.mass for p in system.bodies[0].parts()), start=kn.parameter("none", 0.0) * 0)
    assert eom.evaluate([mass], **rest)[0] == pytest.approx(6.0, rel=1e-12)
    center = eom.evaluate(list(eom.mass_center(O).components(N)), **rest)
    np.testing.assert_allclose(center, [1.0, 0.0, 0.0], atol=1e-12)


def test_places_along_it() -> None:
    b = beam(length=kn.parameter("L", 2.0, "m"))
    assert b.point_at(1) is b.point_at(b.length)
    assert b.point_at(0.5) is b.point_at(b.length / 2)
    assert b.frame_at(1).parent is N
    for wrong in (1.5, -0.1, 2 * b.length, kn.parameter("x", 1.0, "m")):
        with pytest.raises(ModelError, match=r"a position on arm as ξ = x/L from 0, its root, to 1, its tip"):
            b.point_at(wrong)


def test_pickled_with_its_system() -> None:
    _, system = spinning(modes=2)
    again = pickle.loads(pickle.dumps(system))
    assert [q.name for q in again.coordinates] == ["v1_beam", "v2_beam"]
    assert len(again.loads) == len(system.loads) == 1
    assert len(system.replace(speeds="rates").loads) == 1


WRONG = [
    ({"length": 0.0}, "length of arm above zero, got 0"),
    ({"length": -1.0}, "length of arm above zero, got -1"),
    ({"EI": 0.0}, "EI of arm above zero, got 0"),
    ({"EI": kn.parameter("EI", -2.0)}, "EI of arm above zero, got EI = -2"),
    ({"EA": -1.0, "stretch": 1}, "EA of arm above zero"),
    ({"mass_per_length": 0}, "mass_per_length of arm above zero"),
    ({"EI": kn.coordinate("q9")}, "EI of arm in parameters and numbers, got q9"),
    ({"modes": 0}, "at least one function as modes= of arm, got 0"),
    ({"modes": []}, "at least one function as modes= of arm"),
    ({"modes": "legendre"}, r"kn\.mode_shapes\('legendre', …\)"),
    ({"modes": kn.mode_shapes("pinned", 2)}, "its root is clamped, in value and slope, got pinned of which mode 1 has the slope"),
    ({"modes": [lambda x: 1 + x]}, "mode 1 has the value 1 at the root"),
    ({"modes": [lambda x: x**2, lambda x: x**3, lambda x: x**2 - 2 * x**3]}, "got 3 of rank 2: modes 1, 2, 3 depend on each other"),
    ({"modes": [lambda x: x**2, lambda x: 0 * x]}, "mode 2, which is zero"),
    ({"EI": (5.0, 6.0), "modes": (0, 0)}, r"at least one function as modes= of arm, got \(0, 0\)"),
    ({"stiffening": "no"}, "stiffening= of arm to be True or False, got 'no'"),
    ({"support": "welded"}, "support= of arm to be one of clamped, pinned, free"),
    ({"form": "exact"}, "form= of arm to be one of linearized, nonlinear"),
    ({"stretch": 2}, "Expected EA of arm for its stretch=, got none"),
    ({"EA": 1.0, "stretch": kn.mode_shapes("free-free", 1)}, "stretch of arm that are zero at the root"),
    ({"modes": [lambda x: x**3, lambda x: x**4]}, r'bending of arm whose curvatures .* Use kn\.mode_shapes\("polynomials", 2\)'),
    ({"EA": 1.0, "stretch": kn.mode_shapes("legendre", 3)}, r'stretch of arm whose slopes .* got legendre.*\("rod", 3\)'),
    ({"GJ": 1.0, "polar": 1.0, "torsion": kn.mode_shapes("polynomials", 1)}, "twist of arm whose slopes do not all vanish"),
    ({"GJ": 1.0, "torsion": 1}, "polar=moment of inertia about the axis per length of arm"),
    ({"along": N.x}, "along= perpendicular to the axis of arm"),
    ({"axis": N.x + N.y}, "axis of 'arm'|axis of arm"),
    ({"damping": {"zeta": 0.01}}, "damping= of arm by some of mass, stiffness, ratio, got 'zeta'"),
    ({"damping": 0.01}, "damping= of arm as"),
]  # fmt: skip


@pytest.mark.parametrize(("changes", "said"), WRONG, ids=[said[:40] for _, said in WRONG])
def test_refused(changes: dict[str, Any], said: str) -> None:
    with pytest.raises(ModelError, match=said):
        beam(**changes)


def test_cures_work() -> None:
    beam(modes=kn.mode_shapes("legendre", 2))
    beam(modes=kn.mode_shapes("pinned", 2), support="pinned")
    beam(modes=[lambda x: x**2, lambda x: x**3])
    assert len(beam(modes=lambda x: x**2).coordinates) == 1
    beam(EA=1.0, stretch=kn.mode_shapes("rod", 2), GJ=1.0, polar=1.0, torsion=kn.mode_shapes("rod", 1))


def test_units_that_a_beam_chose_ask_nothing_of_a_model_without_units():
    """Where nobody else has units a spring of 5 N/m on a deflection, sin 3t beside a symbol and a threshold of 0.01 are all right."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    q, f = kn.coordinate("q"), kn.parameter("f", 0.1)
    A = N.rotate("A", q, N.z)
    beam = kn.Beam(
        "b",
        O,
        frame=A,
        axis=A.x,
        length=1.0,
        EI=kn.parameter("k", 4.0),
        mass_per_length=0.3,
        modes=1,
        damping={"ratio": 0.01},
    )
    (v,) = beam.coordinates
    loads = [kn.Torque(A, (f + kn.sin(3 * kn.time)) * A.z), kn.Force(beam.point_at(1), -5 * v * A.y)]
    events = [kn.Event("far", v, threshold=0.01)]
    system = kn.System(N, bodies=[beam], loads=loads, speeds={kn.speed("u"): q.dt}, events=events)
    assert len(system.speeds) == 2
    assert {s.name for s in beam.named} == {"v1_b", "L_b", "rhoA_b", "zeta_b"}
    metres = kn.parameter("g", 9.81, "m/s^2")
    with pytest.raises(kn.UnitError, match="angle"):
        kn.System(N, bodies=[beam], loads=[*loads, kn.gravity(-metres * N.y)], speeds={kn.speed("u"): q.dt})


def stepped(x: Any) -> Any:
    return np.where(x < 0.3, 1.0, 0.5)


@pytest.mark.parametrize("form", ["linearized", "nonlinear"])
def test_a_stepped_beam_has_the_integrals_of_its_pieces(form: str) -> None:
    """M and K of bending and twist by SciPy's quadrature on either side of the step, and the mass of both pieces."""
    mass, stiff, polar, torsion = (kn.tapered(x, stepped, breaks=[0.3]) for x in (2.0, 5.0, 0.7, 3.0))
    turning = {"GJ": torsion, "torsion": 2, "polar": polar}
    shaft = beam(length=1.0, mass_per_length=mass, EI=stiff, modes=2, form=form, **turning)
    bent, twisted = shaft.deformation.fields

    def gram(field: Any, order: int, size: float) -> Any:
        def entry(i: int, k: int) -> float:
            pieces = ((0, 0.3, 1.0), (0.3, 1, 0.5))
            values = (quad(lambda x: np.prod(field.shapes.at(x, order)[[i, k]]), a, b)[0] * c for a, b, c in pieces)
            return size * sum(values)

        return np.array([[entry(i, k) for k in range(2)] for i in range(2)])

    eom, still = kn.derive(kn.System(N, bodies=[shaft])), np.zeros(4)
    m = np.array(eom.evaluate(eom.mass_matrix, q=still, u=still), dtype=float)
    k = -np.array([eom.evaluate(eom.Fr, q=q, u=still) for q in np.eye(4)], dtype=float)
    np.testing.assert_allclose(m[:2, :2], gram(bent, 0, 2.0), rtol=1e-11, atol=1e-12)
    np.testing.assert_allclose(m[2:, 2:], gram(twisted, 0, 0.7), rtol=1e-9)
    np.testing.assert_allclose(k[:2, :2], gram(bent, 2, 5.0), rtol=1e-11, atol=1e-9)
    np.testing.assert_allclose(k[2:, 2:], gram(twisted, 1, 3.0), rtol=1e-11, atol=1e-12)
    whole = kn.evaluate([shaft.mass, sum(p.mass for p in shaft.parts())], {})
    np.testing.assert_allclose(whole, 2 * (0.3 + 0.35), rtol=1e-12)


@pytest.mark.parametrize("form", ["linearized", "nonlinear"])
@pytest.mark.parametrize("scale", [1e-8, 1e-3, 1e3, 1e8])
def test_functions_and_tapers_of_any_scale_are_one_beam(form: str, scale: float) -> None:
    """A mode s times as large has a coordinate s times as small; a taper s times as large has a value s times as small."""

    def motion(mode: float, taper: float) -> Any:
        joint = kn.pin("hub", O, N, axis=N.z)
        given = {"axis": joint.frame.x, "frame": joint.frame, "form": form, "damping": {"ratio": 0.02}}
        shapes = kn.mode_shapes([lambda x: mode * x**2 * (3 - x) / 2, lambda x: x**2 * (x - 0.8)])
        mass, stiff = (
            kn.beams.tapered(3.0 / taper, lambda x: taper * (1 - 0.4 * x)),
            kn.beams.tapered(50.0, lambda x: (1 - 0.5 * x) ** 3),
        )
        arm = beam(modes=shapes, mass_per_length=mass, EI=stiff, **given)
        eom = kn.derive(kn.System(N, bodies=[arm], joints=[joint], loads=[kn.gravity(-9.8 * N.y)]))
        q, u = (
            {"q_hub": 0.3, "v1_arm": 0.05 / mode, "v2_arm": -0.03},
            {"u_hub": 4.0, "u_v1_arm": 0.2 / mode, "u_v2_arm": 0.1},
        )
        found = eom.evaluate([*eom.accelerations, eom.kinetic_energy, eom.potential_energy, eom.power], q=q, u=u)
        return np.array(found) * [1, mode, 1, 1, 1, 1]

    usual = motion(1.0, 1.0)
    np.testing.assert_allclose(motion(scale, 1.0), usual, rtol=1e-9)
    np.testing.assert_allclose(motion(1.0, scale), usual, rtol=1e-8)


def test_a_taper_with_steps_is_told() -> None:
    with pytest.warns(kn.KaneWarning, match="Give the positions of the steps: breaks="):
        kn.tapered(1.0, stepped)
    with pytest.warns(kn.KaneWarning, match=r"smooth from ξ = 0 to 0\.5"):
        kn.tapered(1.0, stepped, breaks=(0.5,))
    with pytest.raises(kn.ModelError, match="positions ξ between 0 and 1"):
        kn.tapered(1.0, stepped, breaks=(0.0, 0.3))
    with pytest.raises(kn.ModelError, match=r"the taper to take an array of ξ.*ValueError"):
        kn.tapered(1.0, lambda x: 1.0 if x < 0.3 else 0.5)
    with pytest.raises(kn.ModelError, match=r"number for each ξ, got the shape \(2,\)"):
        kn.tapered(1.0, lambda _: [1.0, 0.5])
    again = pickle.loads(pickle.dumps(kn.tapered(1.0, stepped, breaks=(0.3,))))
    assert again.share.breaks == (0.3,)
    assert again.share(np.array([0.2, 0.4])).tolist() == [1.0, 0.5]

# SPDX-License-Identifier: BSD-3-Clause
"""Lengths that are zero at a state: laws |v|ᵖ v are linearized, trimmed and started at exact rest; |v| alone is refused."""

import numpy as np
import pytest

import kane as kn

N = kn.Frame("N")
O = kn.Point("O", fixed_in=N)
q = kn.coordinates("x y z")
u = kn.speeds("v1:4")
P = O.at("P", q[0] * N.x + q[1] * N.y + q[2] * N.z)
V = P.velocity(N)
c = kn.parameter("c", 0.3)


def body(force, spring=2.0):
    """A particle of 1 kg in space, with a load "drag" and a spring that stiffens."""
    pull = -spring * (kn.sin(q[0] - 0.5) * N.x + q[1] * N.y + (q[2] + q[2] ** 3) * N.z)
    loads = [kn.Force(P, force, name="drag"), kn.Force(P, pull, name="spring")]
    speeds = {s: x.dt for s, x in zip(u, q, strict=True)}
    return kn.derive(kn.System(N, bodies=[kn.Particle("p", P, 1.0)], speeds=speeds, loads=loads))


LAWS = {
    "|v| v": -c * V.magnitude() * V,
    "sqrt(v·v) v": -c * kn.sqrt(V.dot(V)) * V,
    "|v|^0.5 v": -c * V.magnitude() ** 0.5 * V,
    "|v|^1.7 v": -c * V.magnitude() ** 1.7 * V,
    "with a viscous part": -(0.4 + c * V.magnitude()) * V,
    "across": -c * V.reject(N.z).magnitude() * V,
}


@pytest.mark.slow
@pytest.mark.parametrize("name", LAWS)
def test_drag_has_derivatives_at_exact_rest_and_lets_start(name):
    eom = body(LAWS[name])
    viscous = 0.4 if "viscous" in name else 0.0
    for place in ([0.5, 0, 0], [0.9, 0.2, -0.1]):
        one = kn.linearize(eom, q=place, u=[0, 0, 0], steady=place[1] == 0)
        stiffness = np.diag([-2 * np.cos(place[0] - 0.5), -2, -2 - 6 * place[2] ** 2])
        np.testing.assert_allclose(one.A[3:], np.hstack([stiffness, -viscous * np.eye(3)]), atol=1e-12)
    start = kn.simulate(eom, (0, 1), q=[0.9, 0.2, -0.1], u=[0, 0, 0], samples=5)
    assert start.status == "finished"
    assert start.energy_check.relative < 1e-7
    point = kn.equilibrium(eom, q={"x": kn.guess(0.8), "y": kn.guess(0.1), "z": kn.guess(0.1)})
    assert point["x"] == pytest.approx(0.5)


def test_a_length_alone_has_no_derivative_where_it_is_zero():
    with pytest.raises(
        kn.CornerError, match=r"sqrt\(v1\^2 \+ v2\^2 \+ v3\^2\) = 0: derivatives nearby depend on the direction"
    ):
        kn.linearize(body(-c * V.magnitude() * N.x), q=[0.5, 0, 0], u=[0, 0, 0])
    smooth = body(-c * V)
    with pytest.raises(kn.CornerError, match="= 0: derivatives nearby"):
        kn.linearize(smooth, q=[0.5, 0, 0], u=[0, 0, 0], outputs={"speed": V.magnitude()})
    kn.linearize(smooth, q=[0.5, 0, 0], u=[0, 0, 0], outputs={"energy": V.magnitude() ** 3})
    eps = 1e-3
    soft = body(-c * kn.sqrt(V.dot(V) + eps**2) * N.x)  # the cure
    assert not kn.linearize(soft, q=[0.5, 0, 0], u=[0, 0, 0], steady=False).A[3:, 3:].any()


def test_what_has_no_finite_derivative_is_told():
    with pytest.raises(kn.SingularError, match=r"infinity or NaN as a derivative of v1'"):
        kn.linearize(body(kn.sqrt(q[2]) * N.x), q=[0.5, 0, 0], u=[0, 0, 0])


def test_a_load_without_a_direction_is_named_with_cures_that_work():
    told = r"the drag is undefined here.* divides by sqrt\(v1\^2 \+ v2\^2 \+ v3\^2\) = 0.*kn\.friction\(…, smooth=…\)"
    eom = body(-c * V.normalized())
    with pytest.raises(kn.SimulationError, match=told):
        kn.simulate(eom, (0, 1), q=[0.9, 0, 0], u=[0, 0, 0])
    with pytest.raises(kn.SingularError, match=told):
        kn.linearize(eom, q=[0.5, 0, 0], u=[0, 0, 0])
    with pytest.raises(kn.SingularError, match=told):
        kn.equilibrium(eom, q={"x": 0.5})
    soft = body(-c * V / kn.sqrt(V.dot(V) + 1e-3**2))
    assert kn.simulate(soft, (0, 0.1), q=[0.9, 0, 0], u=[0, 0, 0], samples=3).status == "finished"
    quadratic = body(-c * V.magnitude() * V)
    assert kn.simulate(quadratic, (0, 0.1), q=[0.9, 0, 0], u=[0, 0, 0], samples=3).status == "finished"
    rail = kn.slider("rail", O, N, axis=N.x)
    block = kn.Particle("block", rail.point, 1.0)
    loads = [kn.dry_friction(rail, 0.6, smooth=1e-3), kn.Force(rail.point, 2 * N.x)]
    eom = kn.derive(kn.System(N, bodies=[block], joints=[rail], loads=loads))
    assert kn.simulate(eom, (0, 0.1), q=[0], u=[0], samples=3).status == "finished"

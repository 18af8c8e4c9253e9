# SPDX-License-Identifier: BSD-3-Clause
"""The compass gait: two legs with masses and a mass at the hip walk down a slope, without knees and motors.

Both feet are on the slope where θ_ns + θ_s = −2 φ. The strike is plastic: of the whole the angular momentum about the foot that
strikes is
kept, of the leg that leaves that about the hip. The feet pass each other without touching.
"""

import math

import kane as kn

TITLE = "compass gait"
SOURCES = (
    "Goswami, A., Thuilot, B., Espiau, B. (1996), Compass-like biped robot, part I: stability and bifurcation of passive gaits, INRIA "
    "research report 2996.",
    "Goswami, A., Thuilot, B., Espiau, B. (1998), A study of the passive gait of a compass-like biped robot: symmetry and chaos, "
    "Int. J. Robotics Research 17, 1282-1301.",
)
START = {
    "q": {"theta_ns": -0.323388558059, "theta_s": 0.218668802939},
    "u": {"u_ns": -0.377181558403, "u_s": -1.091826677490},
}
"""Just after a strike of the gait on 3°."""


def system() -> kn.System:
    """Both legs by their angles off the vertical, counterclockwise, walking along x; at the event `strike` they change their parts."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    ns, s = kn.coordinate("theta_ns", "rad", "leg that swings"), kn.coordinate("theta_s", "rad", "leg that stands")
    u_ns, u_s = kn.speed("u_ns", "rad/s", "its rate"), kn.speed("u_s", "rad/s", "its rate")
    m = kn.parameter("m", 5.0, "kg", "mass of a leg")
    m_h = kn.parameter("m_H", 10.0, "kg", "mass at the hip")
    a = kn.parameter("a", 0.5, "m", "from a foot to its leg's mass")
    b = kn.parameter("b", 0.5, "m", "from there to the hip")
    slope = kn.parameter("phi", math.radians(3), "rad", "slope")
    g = kn.parameter("g", 9.8, "m/s^2", "acceleration of free fall")

    S, W = N.rotate("S", s, N.z), N.rotate("W", ns, N.z)
    stance = O.at("stance", a * S.y)
    hip = O.at("hip", (a + b) * S.y)
    swing = hip.at("swing", -b * W.y)
    foot = hip.at("foot", -(a + b) * W.y)
    masses = ((stance, m), (hip, m_h), (swing, m))

    # after the strike the foot stands: the masses turn about it, with the rates of the legs as they were named before
    new_s, new_ns = kn.speed("v_s"), kn.speed("v_ns")
    of_hip = (new_s * N.z).cross(hip.position(foot))
    new = {
        swing: (new_s * N.z).cross(swing.position(foot)),
        hip: of_hip,
        stance: of_hip + (new_ns * N.z).cross(stance.position(hip)),
    }
    old = {p: p.velocity(N) for p, _ in masses}

    def momenta(v: dict[kn.Point, kn.Vector]) -> tuple[kn.Expr, kn.Expr]:
        whole = sum((mass * p.position(foot).cross(v[p]).dot(N.z) for p, mass in masses), start=kn.Rational(0, 1))
        return whole, m * stance.position(hip).cross(v[stance]).dot(N.z)

    before, after = momenta(old), momenta(new)
    rates = {ns.dt: u_ns, s.dt: u_s}
    rows = [[kn.diff(row, x) for x in (new_s, new_ns)] for row in after]
    right = [kn.substitute(x, rates) for x in before]
    (p, q), (r, t) = rows
    det = p * t - q * r
    then = {ns: s, s: ns, u_s: (t * right[0] - q * right[1]) / det, u_ns: (p * right[1] - r * right[0]) / det}
    forward = kn.less(s, ns)
    strike = kn.Event(
        "strike", ns + s + 2 * slope, direction=-1, then={x: kn.where(forward, y, x) for x, y in then.items()}
    )
    return kn.System(
        N,
        bodies=[kn.Particle("stance leg", stance, m), kn.Particle("hip", hip, m_h), kn.Particle("swing leg", swing, m)],
        speeds={u_ns: ns.dt, u_s: s.dt},
        loads=[kn.gravity(-g * N.y)],
        events=[strike],
        coordinates=(ns, s),
    )

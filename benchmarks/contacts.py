# SPDX-License-Identifier: BSD-3-Clause
"""Motions with contacts against peers, run by run in turn, with the error of each by a closed form.

A mass on a running belt for 1,000 s, 1,248 changes of mode, against SciPy's `solve_ivp` with events on the compiled right-hand
sides of both modes, with tolerances at which it is as exact. Five boxes on each other, ten contacts, against MuJoCo: at rest for
10 s on a slope of 10°, where what they creep is the error; and on level ground, the upper one thrown at 1 m/s, 2 s, where it is
how far that one comes. MuJoCo has spheres of 0.1 mm as the boxes' corners in a plane, elliptic cones and its Newton solver, with
its own step of 2 ms and with steps of 0.1 ms and 20 iterations against slip.
`python -m benchmarks.contacts` prints the tables.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable
from typing import Any

import mujoco
import numpy as np
import scipy
from scipy.integrate import solve_ivp

import kane as kn
from benchmarks.machine import processor
from benchmarks.paired import paired
from kane.gallery.contacts import mass_on_belt
from kane.motion.steps import Stepper

PAIRS = 15
Array = Any
BELT = 1000.0
BOXES, WIDTH, HEIGHT, FRICTION, SLOPE = 5, 0.5, 0.2, 0.5, math.radians(10)
GRAVITY = 9.81


# A mass on a belt ------------------------------------------------------------------------------------------------------------


def last_slip() -> tuple[int, float]:
    """How many slips begin within the span, and when the last one does, by the closed form."""
    k, m, v, static, kinetic = 25.0, 1.0, 0.2, 0.4, 0.2
    delta, w = (static - kinetic) * m * GRAVITY / k, math.sqrt(k / m)
    period = 2 * delta / v + (math.pi + 2 * math.atan(v / (w * delta))) / w
    first = static * m * GRAVITY / k / v
    n = int((BELT - first) // period)
    return n + 1, first + n * period


def kanes_belt() -> Callable[[], float]:
    """When the last slip begins, as kane has it."""
    eom, start = kn.derive(mass_on_belt.system()), mass_on_belt.START

    def run() -> float:
        sol = kn.simulate(eom, (0, BELT), samples=2, rtol=1e-10, atol=1e-10, q=start["q"], u=start["u"])
        return float(max(t for t, modes in sol.mode_history if modes["belt"] == "slip"))

    return run


def scipys_belt() -> Callable[[], float]:
    """As SciPy has it: the modes' right-hand sides are compiled, and it locates their ends."""
    system = mass_on_belt.system()
    rates: dict[str, Any] = {}
    for mode in ("stick", "straight"):
        eom = kn.derive(system.in_modes({"belt": mode}))
        values = {s.name: float(s.default or 0) for s in eom.parameters}
        p = np.array([-1.0 if s.name.startswith("d_") else values[s.name] for s in eom.parameters])
        own = Stepper(eom, p, ()).now.rates
        rates[mode] = lambda t, x, own=own, p=p: own(t, x, p, None)[:2]
    most, v = 0.4 * GRAVITY, 0.2

    def slips(t: float, x: Array) -> float:
        return float(most - 25.0 * abs(x[0]))

    def sticks(t: float, x: Array) -> float:
        return float(v - x[1])

    for event in (slips, sticks):
        event.terminal, event.direction = True, -1.0  # type: ignore[attr-defined]  # SciPy reads them from the function

    def run() -> float:
        t, x, mode, began = 0.0, np.array([0.0, v]), "stick", 0.0
        while t < BELT:
            ends = slips if mode == "stick" else sticks
            sol = solve_ivp(rates[mode], (t, BELT), x, method="DOP853", events=ends, rtol=1e-12, atol=1e-13)
            t, x = float(sol.t[-1]), sol.y[:, -1]
            if sol.status == 1:
                mode = "straight" if mode == "stick" else "stick"
                began = t if mode == "straight" else began
                x[1] = v
        return began

    return run


# Five boxes ------------------------------------------------------------------------------------------------------------------


def boxes(slope: float) -> kn.System:
    """Boxes on each other, each with two corners on what is below it."""
    N = kn.Frame("N")
    O = place = kn.Point("O", fixed_in=N)
    g, m = kn.parameter("g", GRAVITY, "m/s^2"), kn.parameter("m", 1.0, "kg")
    w, h = kn.parameter("w", WIDTH, "m"), kn.parameter("h", HEIGHT, "m")
    frame, bodies, contacts = N, [], []
    for i in range(BOXES):
        x, y = kn.coordinates(f"x{i} y{i}", "m")
        B = N.rotate(f"B{i}", kn.coordinate(f"a{i}", "rad"), N.z)
        G = O.at(f"G{i}", x * N.x + y * N.y)
        inertia = kn.inertia(B, 0, 0, m * (w**2 + h**2) / 12)
        bodies.append(kn.RigidBody(f"box{i}", frame=B, mass_center=G, mass=m, inertia=inertia))
        for side, name in ((-1, "l"), (1, "r")):
            corner = G.at(f"C{i}{name}", side * w / 2 * B.x - h / 2 * B.y)
            at = kn.joints.point_on_plane(f"c{i}{name}", corner, place, normal=frame.y, along=frame.x)
            contacts.append(kn.contact(at, FRICTION))
        place, frame = G.at(f"T{i}", h / 2 * B.y), B
    down = math.sin(slope) * N.x - math.cos(slope) * N.y
    return kn.System(N, bodies=bodies, speeds="rates", loads=[kn.gravity(g * down)], contacts=contacts)


def kanes_boxes(slope: float, thrown: float, span: float) -> Callable[[], Array]:
    """How far each box has come."""
    eom = kn.derive(boxes(slope))
    q = {f"x{i}": 0.0 for i in range(BOXES)} | {f"a{i}": 0.0 for i in range(BOXES)}
    q |= {f"y{i}": HEIGHT * (i + 0.5) for i in range(BOXES)}
    u = {f"u_{name}": 0.0 for name in q} | {f"u_x{BOXES - 1}": thrown}

    def run() -> Array:
        sol = kn.simulate(eom, (0, span), q=q, u=u, samples=2)
        return np.array([sol[f"x{i}"][-1] for i in range(BOXES)])

    return run


def mujocos_boxes(slope: float, thrown: float, span: float, step: float, noslip: int) -> Callable[[], Array]:
    """How far each box has come."""
    radius = 1e-4
    down = f"{GRAVITY * math.sin(slope)} 0 {-GRAVITY * math.cos(slope)}"
    bodies = []
    for i in range(BOXES):
        bits = 2 ** (i + 1)
        corners = "".join(
            f'<geom type="sphere" size="{radius}" pos="{side * WIDTH / 2} 0 {radius - HEIGHT / 2}" mass="0" condim="3" '
            f'friction="{FRICTION}" contype="{bits // 2}" conaffinity="0"/>'
            for side in (-1, 1)
        )
        bodies.append(
            f'<body name="b{i}" pos="0 0 {HEIGHT * (i + 0.5)}"><joint type="slide" axis="1 0 0"/><joint type="slide" axis="0 0 1"/>'
            f'<joint type="hinge" axis="0 1 0"/><inertial pos="0 0 0" mass="1" diaginertia="1 {(WIDTH**2 + HEIGHT**2) / 12} 1"/>'
            f'<geom type="box" size="{WIDTH} 0.1 {HEIGHT / 2}" contype="0" conaffinity="{bits}" friction="{FRICTION}" mass="0"/>'
            f"{corners}</body>"
        )
    xml = f"""<mujoco><option timestep="{step}" gravity="{down}" cone="elliptic" solver="Newton" noslip_iterations="{noslip}"
        impratio="10" integrator="implicitfast"/><worldbody><geom type="plane" size="10 10 1" contype="0" conaffinity="1"
        friction="{FRICTION}"/>{"".join(bodies)}</worldbody></mujoco>"""
    model = mujoco.MjModel.from_xml_string(xml)
    data = mujoco.MjData(model)
    steps = round(span / step)

    def run() -> Array:
        mujoco.mj_resetData(model, data)
        data.qvel[3 * (BOXES - 1)] = thrown
        mujoco.mj_step(model, data, steps)
        return data.qpos[::3].copy()

    return run


# Tables ----------------------------------------------------------------------------------------------------------------------


def belt() -> None:
    """The table of the belt."""
    slips, exact = last_slip()
    own, peer = kanes_belt(), scipys_belt()
    errors = [abs(run() - exact) for run in (own, peer)]
    print(
        f"A mass on a belt, {BELT:g} s, {slips} slips; errors of the last one's time {errors[0]:.1e} and {errors[1]:.1e} s"
    )
    print("  " + paired(own, peer, PAIRS).line("kane", f"SciPy {scipy.__version__}"))


def stacks() -> None:
    """The tables of the boxes."""
    stops = 1.0 / (2 * FRICTION * GRAVITY)
    for name, case, wanted in (
        ("at rest on a slope of 10°, 10 s", (SLOPE, 0.0, 10.0), np.zeros(BOXES)),
        ("the upper one thrown, 2 s", (0.0, 1.0, 2.0), None),
    ):
        own = kanes_boxes(*case)
        for told, step, noslip in (("2 ms", 2e-3, 0), ("0.1 ms, 20 against slip", 1e-4, 20)):
            peer = mujocos_boxes(*case, step, noslip)
            errors = [
                float(np.abs(run() - wanted).max()) if wanted is not None else abs(float(run()[-1]) - stops)
                for run in (own, peer)
            ]
            print(f"Five boxes, {name}; errors {errors[0]:.1e} and {errors[1]:.1e} m")
            print("  " + paired(own, peer, PAIRS).line("kane", f"MuJoCo {mujoco.__version__} by {told}"))


def main() -> None:
    """Print the tables."""
    print(f"{processor()}; Python {sys.version.split()[0]}")
    belt()
    stacks()


if __name__ == "__main__":
    main()

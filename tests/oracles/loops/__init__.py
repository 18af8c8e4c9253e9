# SPDX-License-Identifier: BSD-3-Clause
"""Newton's and Euler's equations of any bodies, joints and contacts in maximal coordinates, loops included.

A body is the pose of its mass centre and axes and the twist (v, w), all seen from the inertial frame; joints
and contacts are rows on twists. `records` says what is given, `jets` how residuals are differentiated,
`joints` and `contacts` which residuals there are, `rows` stacks them, `equations` solves at one state,
`states` makes states that satisfy them, `motion` follows them in time. It knows nothing of `kane`. A pendulum:

    bodies = [Body(2.0, inertia)]
    joint = Joint((GROUND, 0), (mark(pivot, axis), mark(pivot_on_body, axis_on_body)), joints.pin)
    poses, twists = random_state(rng, bodies, [joint], guess)
    solution = solve(bodies, [joint], poses, twists, gravity=g)  # .a, .alpha, .reactions[0].force, .torque
    run = simulate(bodies, [joint], poses, twists, times, gravity=g, rtol=1e-10)
"""

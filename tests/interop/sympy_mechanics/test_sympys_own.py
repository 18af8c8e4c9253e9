# SPDX-License-Identifier: BSD-3-Clause
"""SymPy's own models come in, with the accelerations of its own equations, or the difference is named."""

import pytest
import sympy.physics.mechanics as me

import kane as kn
from tests.interop.sympy_mechanics.captured import models_of

# How many models each module of tests has, and which of them do not come in, with what the error must say.
NAMED = {
    "test_kane.test_aux": "acceleration that Dmc was given is not the rate of the velocity",
    "test_kane.test_issue_24887": "generalized speed to move some mass",
    "test_kane2.test_sub_qdot2": "a KanesMethod with its bodies",
    "test_lagrange.test_rolling_disc": "velocities in the kinetic energy satisfy motion constraints",
    "test_linearize.test_linearize_rolling_disc_lagrange": "velocities in the kinetic energy satisfy motion constraints",
}
QUICK = {"test_kane4": 6, "test_models": 10}
LONG = {
    "test_kane": 16, "test_kane2": 6, "test_kane5": 1, "test_jointsmethod": 7, "test_lagrange": 5, "test_lagrange2": 1,
    "test_linearize": 6, "test_system_class": 5,
}  # fmt: skip


@pytest.mark.parametrize(
    ("module", "count"), [*QUICK.items(), *(pytest.param(*x, marks=pytest.mark.slow) for x in LONG.items())]
)
def test_models_of_sympys_tests(module, count):
    found = models_of(module)
    assert len(found) >= count
    for model in found:
        if model.error is None:
            assert model.imported.of_kind("checked"), model.place
        else:
            assert NAMED[model.place] in str(model.error), (model.place, str(model.error))


@pytest.mark.parametrize("n", [1, 3])
def test_pendulums_on_a_cart(n):
    """Models that SymPy offers: those with a force and torques have them as inputs."""
    method = me.models.n_link_pendulum_on_cart(n, cart_force=True, joint_torques=True)
    found = kn.from_sympy_mechanics(method)
    assert len(found.system.coordinates) == n + 1
    assert {s.name for s in found.system.inputs} == {"F", *(f"T{k}" for k in range(1, n + 1))}
    assert found.of_kind("checked")

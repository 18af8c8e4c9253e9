# SPDX-License-Identifier: BSD-3-Clause
"""Models of other tools, imported, written as Python and run: the same symbols, operations and accelerations."""

from __future__ import annotations

import warnings
from functools import partial

import numpy as np
import pytest

import kane as kn
from tests.interop.autolev import texts as autolev
from tests.interop.robots import texts as robots
from tests.interop.written import assert_alike, imported
from tests.peer import require

require("sympy")
require("lark")
require("defusedxml")
require("mujoco")
from tests.interop.sympy_mechanics import models as mechanics  # noqa: E402

KINDS = ("revolute", "continuous", "prismatic", "fixed", "planar", "floating")


def tree(plain, mimic, **options):
    return kn.from_urdf(robots.urdf(list(KINDS), np.random.default_rng(3), plain=plain, mimic=mimic), **options)


def mechanical(name):
    return kn.from_sympy_mechanics(getattr(mechanics, name)())


MODELS = {
    "urdf arm": lambda: kn.from_urdf(robots.ARM),
    "urdf tree": lambda: tree(True, True, parameters="masses"),
    "urdf tree in numbers": lambda: tree(False, False, parameters="none"),
    "urdf tree with a mimic": lambda: tree(False, True),
    "urdf arm that rubs and stops": lambda: kn.from_urdf(robots.ARM, stops=True, friction=True),
    **{f"mjcf {n}": partial(kn.from_mjcf, t) for n, t in robots.MODELS.items()},
    **{
        f"autolev {n.lower()}": partial(kn.from_autolev, t)
        for n, t in vars(autolev).items()
        if n.isupper() and isinstance(t, str)
    },
    **{
        f"sympy {n}": partial(mechanical, n)
        for n in ("pendulum", "velocity_alone", "rotor", "tumbling", "knife_edge", "four_bar", "tension", "joints", "lagrange")
    },
    "sympy axis": lambda: kn.from_sympy_mechanics(mechanics.oriented("axis")),
    "sympy quaternion": lambda: kn.from_sympy_mechanics(mechanics.quaternion(True)),
}  # fmt: skip
QUICK = {
    "urdf arm", "urdf tree", "mjcf four-bar", "mjcf weld", "mjcf actuators", "autolev double", "autolev genesis_pendulum",
    "autolev skate", "autolev rolling", "sympy pendulum", "sympy rotor", "sympy four_bar", "sympy knife_edge",
}  # fmt: skip
assert set(MODELS) >= QUICK


@pytest.mark.parametrize("name", [pytest.param(n, marks=() if n in QUICK else pytest.mark.slow) for n in MODELS])
def test_what_was_imported_is_written(name, tmp_path):
    model = MODELS[name]()
    text = kn.exchange.to_python(model.system, title=name, remarks=map(str, model.remarks))
    assert max(map(len, text.splitlines())) <= 118
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "The constraint '.*' is always satisfied", kn.KaneWarning)
        assert_alike(model.system, imported(tmp_path / "model.py", text).system())

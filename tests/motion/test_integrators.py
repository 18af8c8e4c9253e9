# SPDX-License-Identifier: BSD-3-Clause
"""Integrators as records of their options: the motion of a name and keywords, to the bit."""

import pickle

import numpy as np
import pytest

import kane as kn
from kane.gallery import pendulums
from kane.motion import INTEGRATORS

EOM = kn.derive(pendulums.system(2))
START = {"q": [0.4, 0.3], "u": [0, 0], "samples": 11}
RECORDS = [getattr(kn.integrators, name) for name in kn.integrators.__all__]
ADAPTIVE = [r for r in RECORDS if issubclass(r, kn.AdaptiveStep) and r.name]
FIXED = [r for r in RECORDS if issubclass(r, kn.FixedStep) and r.name]


def test_every_integrator_has_a_record():
    names = {record.name for record in (*ADAPTIVE, *FIXED)}
    assert names == {"auto", *INTEGRATORS, "RK23", "RK45", "DOP853", "Radau", "BDF", "LSODA", "cvode"}
    assert {record.name for record in FIXED} == {name for name, i in INTEGRATORS.items() if i.fixed}


@pytest.mark.parametrize("record", [r for r in ADAPTIVE if r is not kn.Cvode])
def test_a_record_is_a_name_and_options(record):
    options = {"rtol": 1e-6, "atol": 1e-7, "max_step": 0.1, "first_step": 0.01}
    one = kn.simulate(EOM, (0, 1), **START, method=record(**options))
    two = kn.simulate(EOM, (0, 1), **START, method=record.name, **options)
    run = kn.prepare(EOM, (0, 1), method=record(**options), samples=11)
    for motion in (one, run(START["q"], START["u"])):
        assert np.array_equal(motion.states, two.states)
        assert (motion.method, motion.rtol, motion.atol) == (two.method, 1e-6, 1e-7)


@pytest.mark.parametrize("record", FIXED)
def test_a_fixed_step(record):
    one = kn.simulate(EOM, (0, 1), **START, method=record(step=0.001))
    assert one.steps == 1000
    assert np.array_equal(one.states, kn.simulate(EOM, (0, 1), **START, method=record.name, max_step=0.001).states)


def test_options_beside_a_record():
    """Those that it leaves open may be given."""
    one = kn.simulate(EOM, (0, 1), **START, method=kn.Gauss16(rtol=1e-7), atol=1e-8)
    assert (one.rtol, one.atol) == (1e-7, 1e-8)
    with pytest.raises(
        kn.SimulationError, match=r"Expected rtol= in method=Gauss16\(rtol=1e-07.*or beside it, got both"
    ):
        kn.simulate(EOM, (0, 1), **START, method=kn.Gauss16(rtol=1e-7), rtol=1e-8)
    with pytest.raises(kn.SimulationError, match="Expected max_step= in method=Midpoint"):
        kn.prepare(EOM, (0, 1), method=kn.Midpoint(0.1), max_step=0.2)
    with pytest.raises(kn.SimulationError, match="Expected rtol > 0"):
        kn.simulate(EOM, (0, 1), **START, method=kn.Gauss16(rtol=-1.0))
    with pytest.raises(kn.SimulationError, match="Expected method to be one of"):
        kn.simulate(EOM, (0, 1), **START, method=kn.Gauss16)


def test_records_are_values():
    assert kn.Gauss16(rtol=1e-7) == kn.Gauss16(rtol=1e-7) != kn.Dop853(rtol=1e-7)
    assert pickle.loads(pickle.dumps(kn.Midpoint(0.1))) == kn.Midpoint(step=0.1)
    assert repr(kn.Radau9()) == "Radau9(rtol=None, atol=None, max_step=None, first_step=None)"
    with pytest.raises(AttributeError):
        kn.Gauss16().rtol = 1.0

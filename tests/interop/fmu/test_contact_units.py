# SPDX-License-Identifier: BSD-3-Clause
"""Units with contacts, for co-simulation: valid, on the motion of `kn.simulate`, from mode to mode within steps."""

import numpy as np
import pytest

import kane as kn
from tests.interop.fmu.units import TIGHT, far, instantiated, model, reference, states_of, written
from tests.motion.test_c_contacts import block
from tests.peer import require

fmpy = require("fmpy")
validation = require("fmpy.validation")


def ran(unit, end, samples, **more):
    """What fmpy records at `samples` communication points."""
    return fmpy.simulate_fmu(
        str(unit.path), fmi_type="CoSimulation", stop_time=end, step_size=end / (samples - 1), relative_tolerance=TIGHT,
        output_interval=end / (samples - 1), record_events=False, timeout=60, **more,
    )  # fmt: skip


ENDS = {"bouncing_ball": 2.0, "mass_on_belt": 5.0, "rocking_block": 3.0, "stacked_blocks": 2.0, "pool_ball": 1.0}


@pytest.mark.slow
@pytest.mark.parametrize("version", ["2.0", "3.0"])
@pytest.mark.parametrize("name", sorted(ENDS))
def test_the_motion_is_that_of_simulate(tmp_path, name, version):
    """Impacts, stick and slip between communication points."""
    end = ENDS[name]
    eom, given = model(name)
    unit = written(tmp_path, name, eom, given, version=version)
    assert validation.validate_fmu(str(unit.path)) == []
    sol = reference(eom, end, 21, given)
    expected = sol.states[[np.flatnonzero(sol.t <= t + 1e-12)[-1] for t in np.linspace(0, end, 21)]]
    found = states_of(ran(unit, end, 21, output=[s.name for s in eom.state]), eom)
    assert far(found, expected) < 1e-8

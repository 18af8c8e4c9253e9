# SPDX-License-Identifier: BSD-3-Clause
"""The spin-up of a beam against geometrically exact finite elements: Exudyn's cable elements (ANCF, bending and stretch)."""

from __future__ import annotations

from importlib import import_module

import numpy as np
import pytest

from tests.literature import test_spin_up as spin_up
from tests.peer import require

exudyn = require("exudyn")
ELEMENTS, STEPS = 4, 2000  # with 16 elements and 4000 steps the peak changes by 0.01 %


def lag_of_cables() -> np.ndarray:
    """Deflection of the tip (m), the first node's slope turned as the hub."""
    items, beams = import_module("exudyn.itemInterface"), import_module("exudyn.beams")
    mbs = exudyn.SystemContainer().AddSystem()
    ground = mbs.AddMarker(
        items.MarkerNodeCoordinate(
            nodeNumber=mbs.AddNode(items.NodePointGround(referenceCoordinates=[0, 0, 0])), coordinate=0
        )
    )
    cable = items.Cable2D(
        physicsMassPerLength=1.2,
        physicsBendingStiffness=1.4e4,
        physicsAxialStiffness=2.8e7,
        useReducedOrderIntegration=2,
    )
    nodes = beams.GenerateStraightLineANCFCable2D(mbs, [0, 0, 0], [10, 0, 0], ELEMENTS, cable)[0]
    turns = {2: lambda mbs, t, i, offset: np.cos(turned(t)) - 1, 3: lambda mbs, t, i, offset: np.sin(turned(t))}
    for k in range(4):
        marker = mbs.AddMarker(items.MarkerNodeCoordinate(nodeNumber=nodes[0], coordinate=k))
        more = {"offsetUserFunction": turns[k]} if k in turns else {}
        mbs.AddObject(items.CoordinateConstraint(markerNumbers=[ground, marker], **more))
    sensor = mbs.AddSensor(
        items.SensorNode(
            nodeNumber=nodes[-1], storeInternal=True, outputVariableType=exudyn.OutputVariableType.Position
        )
    )
    mbs.Assemble()
    settings = exudyn.SimulationSettings()
    settings.timeIntegration.numberOfSteps, settings.timeIntegration.endTime = STEPS, 20
    settings.timeIntegration.generalizedAlpha.spectralRadius = 0.9
    settings.timeIntegration.verboseMode = 0
    settings.solution.file.write = False
    settings.solution.sensors.writePeriod = 0.01
    mbs.SolveDynamic(settings)
    t, x, y = np.array(mbs.GetSensorStoredData(sensor)).T[:3]
    angle = np.array([turned(time) for time in t])
    lag: np.ndarray = np.cos(angle) * y - np.sin(angle) * x
    return lag


def turned(t: float) -> float:
    """θ of the hub."""
    a = 2 * np.pi / spin_up.RAMP
    if t >= spin_up.RAMP:
        return spin_up.SPIN * (t - spin_up.RAMP / 2)
    return float(spin_up.SPIN / spin_up.RAMP * (t**2 / 2 + (np.cos(a * t) - 1) / a**2))


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::DeprecationWarning")
def test_peak_lag() -> None:
    """0.574 m: the nonlinear form to 0.5 %, the linearized one too for so small slopes."""
    peak = lag_of_cables().min()
    for form in ("nonlinear", "linearized"):
        assert spin_up.lag(form=form).min() == pytest.approx(peak, rel=5e-3)

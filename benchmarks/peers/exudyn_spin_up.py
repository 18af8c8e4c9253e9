# SPDX-License-Identifier: BSD-3-Clause
"""The spin-up of a beam by Exudyn: geometrically exact cable elements (ANCF, bending and stretch), the root turned as prescribed."""

from __future__ import annotations

import time
import warnings
from typing import Any, NamedTuple

import numpy as np

from benchmarks.native import Array

LENGTH, MASS, BENDING, AXIAL = 10.0, 1.2, 1.4e4, 2.8e7
SPIN, RISE, END = 6.0, 15.0, 20.0
_A = 2 * np.pi / RISE


class Setting(NamedTuple):
    """Elements, steps of generalized-α and its spectral radius, and whether its Newton's method keeps its Jacobian."""

    elements: int
    steps: int
    radius: float = 0.9
    modified: bool = False

    def __str__(self) -> str:
        newton = "modified Newton" if self.modified else "Newton"
        return f"{self.elements} elements, {self.steps} steps, spectral radius {self.radius:g}, {newton}"


def turned(t: Array) -> Array:
    """θ of the hub at times."""
    ramp = SPIN / RISE * (t**2 / 2 + (np.cos(_A * t) - 1) / _A**2)
    return np.where(t < RISE, ramp, SPIN * (t - RISE / 2))


def spun(setting: Setting, write: float = 0.1) -> tuple[Array, float]:
    """Deflection of the tip (m) every `write` seconds, and the seconds that the solver took, its model built before."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # of Exudyn's own functions
        return _spun(setting, write)


def _spun(setting: Setting, write: float) -> tuple[Array, float]:
    import exudyn

    mbs = exudyn.SystemContainer().AddSystem()
    sensor = _built(mbs, setting.elements)
    settings = exudyn.SimulationSettings()
    integration = settings.timeIntegration
    integration.numberOfSteps, integration.endTime = setting.steps, END
    integration.generalizedAlpha.spectralRadius = setting.radius
    integration.newton.useModifiedNewton = setting.modified
    integration.verboseMode = 0
    settings.solution.file.write = False
    settings.solution.sensors.writePeriod = write
    settings.linearSolverType = exudyn.LinearSolverType.EXUdense
    start = time.perf_counter()
    mbs.SolveDynamic(settings)
    seconds = time.perf_counter() - start
    t, x, y = np.array(mbs.GetSensorStoredData(sensor)).T[:3]
    angle = turned(t)
    return np.cos(angle) * y - np.sin(angle) * x, seconds


def _built(mbs: Any, elements: int) -> Any:
    """The beam, its first node's place held, its slope turned; the sensor of its tip."""
    import exudyn
    from exudyn import beams
    from exudyn import itemInterface as items
    from exudyn.advancedUtilities import CreateSymbolicUserFunction

    node = mbs.AddNode(items.NodePointGround(referenceCoordinates=[0, 0, 0]))
    ground = mbs.AddMarker(items.MarkerNodeCoordinate(nodeNumber=node, coordinate=0))
    cable = items.Cable2D(
        physicsMassPerLength=MASS,
        physicsBendingStiffness=BENDING,
        physicsAxialStiffness=AXIAL,
        useReducedOrderIntegration=2,
    )
    nodes = beams.GenerateStraightLineANCFCable2D(mbs, [0, 0, 0], [LENGTH, 0, 0], elements, cable)[0]
    symbolic = exudyn.symbolic

    def angle(t: Any) -> Any:
        ramp = SPIN / RISE * (t * t * 0.5 + (symbolic.cos(_A * t) - 1) * (1 / _A**2))
        return symbolic.IfThenElse(t < RISE, ramp, SPIN * (t - RISE / 2))

    # by symbols they are evaluated in Exudyn's own code, twice as fast as in Python
    turns = {
        2: lambda mbs, t, i, offset: symbolic.cos(angle(t)) - 1,
        3: lambda mbs, t, i, offset: symbolic.sin(angle(t)),
    }
    for k in range(4):
        marker = mbs.AddMarker(items.MarkerNodeCoordinate(nodeNumber=nodes[0], coordinate=k))
        joint = mbs.AddObject(items.CoordinateConstraint(markerNumbers=[ground, marker], offsetUserFunction=0))
        if k in turns:
            turn = CreateSymbolicUserFunction(mbs, turns[k], "offsetUserFunction", joint)
            mbs.SetObjectParameter(joint, "offsetUserFunction", turn)
    position = exudyn.OutputVariableType.Position
    sensor = mbs.AddSensor(items.SensorNode(nodeNumber=nodes[-1], storeInternal=True, outputVariableType=position))
    mbs.Assemble()
    return sensor

# SPDX-License-Identifier: BSD-3-Clause
"""Motions: start, steps, projection, events, Solution."""

from kane.lazy_imports import offered

__getattr__ = offered(
    __name__,
    {
        "constraint_kernels": "Holding holding",
        "contact_motion": "ContactMotion",
        "contact_runner": "ContactRunner",
        "hybrid.event_routines": "actions glance tendency",
        "hybrid.automaton": "automaton",
        "hybrid.events": "crossings",
        "hybrid.sides": "unfit",
        "inputs.": "smooth",
        "solvers.": "cvode",
        "inputs.breakpoints": "breakpoints bumps bumps_of pulses",
        "inputs.expressions": "Formula Sampled",
        "inputs.functions": "Asked input_functions jumps",
        "arguments": "by_kind",
        "course": "Method",
        "lanes": "Ends run_in_lanes runs_in_lanes",
        "methods": "cornered SOLVERS",
        "native": "NativeCourse",
        "projection": "ConstraintProjection constraint_numbers constraint_projection crosses is_constrained looked_at",
        "right_hand_side": "has_jumps quantities rates routines unembedded entries exact pattern",
        "simulator_c": "METHODS emit_simulator",
        "solution.checks": "energy_check taken",
        "solution.files": "Contents read write",
        "start": "nearly_singular pivots check_span check_steps check_tolerance sample_times",
        "steppers.collocation": "defects events gauss integrals lagrange radau radau_stages",
        "steppers.dense": "decompose factor invert solve substitute",
        "steppers.dop853": "DOP853",
        "steppers.gauss": "along gauss_kernel",
        "steppers.context": "ReturnCode SIZE Slot",
        "steppers.rk4": "RK4",
        "steppers.table": "EXPLICIT INTEGRATORS compiled",
        "steppers.tsit5": "TSIT5",
        "steppers.tsitpap8": "TSITPAP8",
        "steppers.vern9": "VERN9",
        "steps": "Stepper",
    },
)

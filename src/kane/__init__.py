# SPDX-License-Identifier: BSD-3-Clause
"""Equations of motion by Kane's method: derived, compiled, simulated and shown.

Declare frames, points, bodies, loads and generalized speeds, gather them in a `System`, and `derive` its `Equations`.
"""

import logging
from typing import TYPE_CHECKING

from kane.lazy_imports import offered as _offered

# A public name is imported when it is first used (PEP 562), so that `import kane` takes next to no time: for type checkers it is
# imported here, at run time `_NAMES` says from where.
if TYPE_CHECKING:
    from kane import analysis, attitude, beams, errors, expr, figures, integrators, joints, loads, solids
    from kane import cycles as cycles
    from kane import exchange as exchange
    from kane import fitting as fitting
    from kane.analysis import *
    from kane.attitude import *
    from kane.beams import *
    from kane.cycles import *
    from kane.equations.compiled import Compiled
    from kane.equations.compiled import Handle as Handle
    from kane.equations.equations import Equations, compile, derive
    from kane.equations.jacobian import Jacobian
    from kane.equations.state import OperatingPoint as OperatingPoint
    from kane.equations.state import State
    from kane.errors import *
    from kane.exchange import *
    from kane.expr import *
    from kane.expr.node import pi
    from kane.expr.operators import (
        Rational,
        abs,
        acos,
        asin,
        atan,
        atan2,
        cos,
        cosh,
        exp,
        less,
        log,
        max,
        min,
        sign,
        sin,
        sinh,
        sqrt,
        tan,
        tanh,
        where,
    )
    from kane.expr.piecewise import table
    from kane.expr.symbols import (
        coordinate,
        coordinates,
        input,
        inputs,
        parameter,
        parameters,
        speed,
        speeds,
        state,
        time,
    )
    from kane.figures import *
    from kane.fitting import *
    from kane.integrators import *
    from kane.interop.autolev import from_autolev as from_autolev
    from kane.interop.fmu.archive import FMU as FMU
    from kane.interop.fmu.archive import to_fmu as to_fmu
    from kane.interop.imported import Imported as Imported
    from kane.interop.imported import Remark as Remark
    from kane.interop.robots.mjcf import from_mjcf as from_mjcf
    from kane.interop.robots.records import LinkShape as LinkShape
    from kane.interop.robots.urdf import from_urdf as from_urdf
    from kane.interop.sympy import from_sympy, to_sympy
    from kane.interop.sympy_mechanics.importing import from_sympy_mechanics as from_sympy_mechanics
    from kane.joints import *
    from kane.loads import *
    from kane.model.bodies import Particle, RigidBody
    from kane.model.constraints import (
        Constraint,
        auxiliary_speed,
        coincident,
        configuration_constraint,
        distance,
        motion_constraint,
        no_slip,
        parallel,
        perpendicular,
        reaction,
        rolling,
        touching,
    )
    from kane.model.contacts import contact
    from kane.model.declarations import Event
    from kane.model.system import System
    from kane.motion.inputs.expressions import sampled
    from kane.motion.inputs.functions import Signal, signal
    from kane.motion.load import load_solution
    from kane.motion.many.simulate_many import simulate_many
    from kane.motion.prepared import Prepared as Prepared
    from kane.motion.prepared import prepare
    from kane.motion.simulate import simulate
    from kane.motion.solution.accuracy import Accuracy as Accuracy
    from kane.motion.solution.solution import Solution
    from kane.present.provenance import show_versions
    from kane.program.native.machine import Settings
    from kane.solids import *
    from kane.space.frame import Frame, Point
    from kane.space.vector import Dyadic, Vector
    from kane.units.rules import unit_of
    from kane.write.arrange import to_text
    from kane.write.latex import to_latex

__version__ = "0.2.0"

logging.getLogger("kane").addHandler(logging.NullHandler())  # a library says nothing unless it is asked to

_NAMES = {
    "": "analysis attitude beams cycles errors exchange expr figures fitting integrators joints loads solids",
    "analysis.assembly": "Assembled assemble",
    "analysis.comparison": "MethodComparison SpeedComparison SpeedSet compare_methods compare_speeds",
    "analysis.constraint_loads": "ConstraintForces constraint_forces Impact impact",
    "analysis.inertial_regressor": "BaseParameters Regressor regressor",
    "analysis.linear": "Linear Mode NormalModes SecondOrder normal_modes",
    "analysis.linearization": "Linearizer SymbolicLinear linearize linearize_symbolic linearizer",
    "analysis.mixed_dynamics": "Inverse inverse",
    "analysis.solution_branches": "Branch Crossing continuation",
    "analysis.trimming": "equilibrium trim",
    "dynamics.formalisms": "Formulation",
    "dynamics.motions": "Motions motions",
    "dynamics.readings.contributions": "Noncontributing",
    "dynamics.readings.joint_reactions": "JointReaction",
    "equations.compiled": "Compiled Handle",
    "equations.equations": "Equations compile derive",
    "equations.jacobian": "Jacobian",
    "equations.state": "Guess OperatingPoint State guess",
    "errors":
        "ArgumentError ContactError CornerError ExpressionError KaneError KaneWarning MissingAttributeError ModelError "
        "ModesWarning NotAffineError NotFiniteError PotentialError ProgramError ReactionError SimulationError "
        "SingularError SolutionFileError SpaceError SpeedsError StiffeningWarning UnitError ValueMissingError",
    "expr.differentiation": "diff gradient jacobian time_derivative affine",
    "expr.evaluation": "Operations count_operations evaluate free_symbols",
    "expr.matrix": "Matrix solve_linear",
    "expr.node": "Expr pi",
    "expr.operators":
        "Rational abs acos asin atan atan2 cos cosh exp less log max min sign sin sinh sqrt tan tanh where",
    "expr.visit": "substitute",
    "expr.symbols":
        "AuxiliarySpeed Coordinate Input Parameter Rate Reaction Speed StateVariable Symbol coordinate "
        "coordinates input inputs parameter parameters speed speeds state time",
    "expr.piecewise": "Table table",
    "expr.forms.taylor_series": "taylor",
    "interop.python_source.model": "to_python",
    "interop.autodiff": "to_casadi to_jax to_torch",
    "interop.imported": "Imported Remark",
    "interop.robots.mjcf": "from_mjcf",
    "interop.robots.records": "LinkShape",
    "interop.robots.urdf": "from_urdf",
    "interop.autolev": "from_autolev",
    "interop.fmu.archive": "FMU to_fmu",
    "interop.sympy": "from_sympy to_sympy",
    "interop.sympy_mechanics.importing": "from_sympy_mechanics",
    "model.beams.beam": "Beam",
    "model.beams.deformation": "tapered",
    "model.beams.shape_functions": "ModeShapes mode_shapes",
    "model.bodies": "Particle RigidBody",
    "model.constraints":
        "Constraint coincident configuration_constraint distance motion_constraint no_slip parallel perpendicular "
        "rolling touching auxiliary_speed reaction",
    "model.declarations": "Event",
    "model.field_loads":
        "buoyancy gravitation gravity_moment line_load linear_drag pressure_on_disk pressure_on_rectangle "
        "quadratic_drag",
    "model.force_systems": "ForceSystem Wrench force_system",
    "model.joints.closing":
        "close_ball close_cylindrical close_pin close_planar close_screw close_slider close_universal close_weld",
    "model.contacts": "ContactLaw ContactMode capstan clutch contact drilling_resistance rolling_resistance rope stiction stop "
        "stribeck",
    "model.joints.contact":
        "Contact capsule_on_plane corners_on_plane disk_on_plane dry_friction friction point_on_plane sphere_on_cylinder "
        "sphere_on_plane sphere_on_sphere torus_on_plane",
    "model.joints.gears": "bevel_pair gear_pair rack_and_pinion worm_pair",
    "model.joints.joint": "Joint ball cylindrical free pin planar screw slider universal weld",
    "model.loads":
        "Force Gravity Load Torque action_reaction gravity linear_damper linear_spring torque_pair "
        "torsional_damper torsional_spring",
    "model.mass":
        "composite inertia_about inertia_matrix inertia_vector mass_center moment_of_inertia Principal principal "
        "product_of_inertia radius_of_gyration",
    "model.solids":
        "box central_inertia circular_arc circular_sector cylindrical_shell ellipsoid frustum half_cylinder "
        "hemisphere inertia parallel_axis rectangular_plate right_triangle ring rod solid_cone solid_cylinder "
        "solid_sphere spherical_shell thin_disk torus triangular_plate",
    "model.system": "System",
    "motion.cycles.branch": "CycleBranch CycleChange",
    "motion.cycles.limit_cycle": "LimitCycle limit_cycle",
    "motion.cycles.section": "SectionPoints poincare",
    "motion.derivatives.motion_derivatives": "AdjointSensitivities Cost Sensitivities",
    "motion.fitting.fit": "Fit fit",
    "motion.fitting.sensitivities": "sensitivities",
    "motion.fitting.shoot": "Curve Shot curve shoot",
    "motion.solution.accuracy": "Accuracy",
    "motion.inputs.functions": "Signal signal",
    "motion.inputs.expressions": "sampled",
    "motion.load": "load_solution",
    "motion.many.simulate_many": "simulate_many",
    "motion.integrators":
        "AdaptiveStep Auto Cvode Dop853 FixedStep Gauss16 Lsoda Midpoint Radau9 Rk4 ScipyBDF ScipyDOP853 ScipyRK23 "
        "ScipyRK45 ScipyRadau Tsit5 Tsitpap8 Vern9",
    "motion.prepared": "Prepared prepare",
    "motion.simulate": "simulate",
    "motion.solution.solution": "Solution",
    "present.analysis_figures": "beam_figure cycle_figure energy_balance fit_figure mode_figure",
    "present.linearized.branch_figures": "campbell_diagram root_locus",
    "present.animation": "Animation animate",
    "present.check_figures": "Check",
    "present.figure": "plot",
    "present.provenance": "show_versions",
    "present.report": "report",
    "present.scene.gather": "scene",
    "present.scene.records": "Scene",
    "present.scene.shapes": "BodyShape link_shapes shape",
    "present.sketch.draw": "Sketch sketch",
    "program.native.machine": "Settings",
    "space.attitude": "Rotation small_rotation",
    "space.frame": "Frame Point",
    "space.vector": "Dyadic Vector",
    "units.rules": "unit_of",
    "write.arrange": "to_text",
    "write.latex": "to_latex",
}  # fmt: skip
"""The public names of each module, and families, which are modules themselves."""

_other_names = {
    "Frame": "ReferenceFrame",
    "RigidBody": "Body",
    "System": "Model",
    "ball": "spherical SphericalJoint",
    "configuration_constraint": "holonomic prescribe",
    "coordinate": "dynamicsymbols",
    "derive": "KanesMethod LagrangesMethod",
    "free": "floating sixdof",
    "linear_damper": "damper",
    "linear_spring": "spring",
    "motion_constraint": "nonholonomic",
    "parameter": "symbols constant",
    "pin": "revolute hinge PinJoint RevoluteJoint",
    "evaluate": "evalf",
    "simulate": "integrate solve odeint solve_ivp",
    "slider": "prismatic PrismaticJoint",
    "solve_linear": "inv LUsolve",
    "substitute": "subs msubs xreplace",
    "table": "interp interp1d lookup LookupTable spline",
    "time": "t",
    "to_latex": "latex vlatex mlatex",
    "where": "Piecewise ifelse",
}
"""What other tools call them."""

if not TYPE_CHECKING:  # checkers of types know the names
    __getattr__ = _offered(__name__, _NAMES)

# In reading order: declare, derive, look, run. Names of families that are not in this list can be reached here, too.
__all__ = [
    "coordinates", "coordinate", "speeds", "speed", "parameters", "parameter", "inputs", "input", "state",
    "time", "pi",
    "Rational",
    "sqrt", "sin", "cos", "tan", "asin", "acos", "atan", "atan2", "sinh", "cosh", "tanh", "exp", "log", "abs", "sign",
    "min", "max", "where", "less", "table",
    "Frame", "Point", "Vector", "Dyadic", "attitude",
    "pin", "slider", "ball", "free", "joints",
    "RigidBody", "Particle", "inertia", "solids", "Beam", "beams",
    "Force", "Torque", "gravity", "linear_spring", "linear_damper", "torsional_spring", "torsional_damper", "friction",
    "loads",
    "Constraint", "coincident", "distance", "perpendicular", "parallel", "no_slip", "touching", "rolling",
    "configuration_constraint", "motion_constraint", "contact",
    "reaction", "auxiliary_speed", "Event", "System",
    "derive", "Equations", "compile", "Compiled", "Jacobian", "Settings", "State", "assemble", "guess",
    "signal", "Signal", "sampled", "simulate", "simulate_many", "prepare", "integrators", "Solution", "load_solution",
    "linearize", "trim", "equilibrium", "inverse", "analysis", "plot", "report", "figures",
    "Expr", "Matrix", "diff", "gradient", "jacobian", "time_derivative", "substitute", "evaluate", "free_symbols",
    "unit_of", "to_text", "to_latex", "to_sympy", "from_sympy", "expr",
    "KaneError", "KaneWarning", "ModelError", "SimulationError", "errors",
    "show_versions", "__version__",
]  # fmt: skip

# SPDX-License-Identifier: BSD-3-Clause
"""Equations of motion by Kane's method: derived, compiled, simulated and shown.

Declare frames, points, bodies, loads and generalized speeds, gather them in a `System`, and `derive` its `Equations`.
"""

import logging
from typing import TYPE_CHECKING

from kane.lazy import offered as _offered

# A public name is imported when it is first used (PEP 562), so that `import kane` takes next to no time: for type checkers it is
# imported here, at run time `_NAMES` says from where.
if TYPE_CHECKING:
    from kane.analysis.assembly import Assembled, assemble
    from kane.analysis.constraint_loads import ConstraintForces, constraint_forces
    from kane.analysis.impacts import Impact, impact
    from kane.analysis.inverse_dynamics import Inverse, inverse
    from kane.analysis.linear import Linear, Mode, SecondOrder
    from kane.analysis.linearization import Linearizer, linearize, linearizer
    from kane.analysis.method_comparison import MethodComparison, compare_methods
    from kane.analysis.modes import NormalModes, normal_modes
    from kane.analysis.point import OperatingPoint
    from kane.analysis.solution_branches import Branch, continuation
    from kane.analysis.speed_comparison import SpeedComparison, SpeedSet, compare_speeds
    from kane.analysis.stability import Crossing
    from kane.analysis.state import Guess, guess
    from kane.analysis.symbolic import SymbolicLinear, linearize_symbolic
    from kane.analysis.trimming import equilibrium, trim
    from kane.dynamics.methods.formulation import Formulation
    from kane.dynamics.motions import Motions, motions
    from kane.dynamics.readings.joint_reactions import JointReaction
    from kane.dynamics.readings.noncontributing import Noncontributing
    from kane.equations.compiled import Compiled
    from kane.equations.derive import derive
    from kane.equations.equations import Equations, compile
    from kane.equations.handle import Handle
    from kane.equations.jacobian import Jacobian
    from kane.errors import (
        ArgumentError,
        CornerError,
        ExpressionError,
        KaneError,
        KaneWarning,
        MissingAttributeError,
        ModelError,
        ModesWarning,
        NotAffineError,
        NotFiniteError,
        PotentialError,
        ProgramError,
        ReactionError,
        SimulationError,
        SingularError,
        SolutionFileError,
        SpaceError,
        SpeedsError,
        StiffeningWarning,
        UnitError,
        ValueMissingError,
    )
    from kane.expr.count import Operations, count_operations
    from kane.expr.differentiation import diff, gradient, jacobian, time_derivative
    from kane.expr.evaluation import evaluate, free_symbols
    from kane.expr.linear_parts import affine
    from kane.expr.matrix import Matrix
    from kane.expr.node import Expr, pi
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
    from kane.expr.solve import solve_linear
    from kane.expr.substitution import substitute
    from kane.expr.symbols import (
        AuxiliarySpeed,
        Coordinate,
        Input,
        Parameter,
        Rate,
        Reaction,
        Speed,
        State,
        Symbol,
        coordinate,
        coordinates,
        input,
        parameter,
        parameters,
        speed,
        speeds,
        state,
        time,
    )
    from kane.expr.tables import Table, table
    from kane.expr.taylor_series import taylor
    from kane.interop.sympy import from_sympy, to_sympy
    from kane.model.beams.beam import Beam
    from kane.model.beams.section import tapered
    from kane.model.beams.shapes import ModeShapes, mode_shapes
    from kane.model.bodies import Particle, RigidBody
    from kane.model.constraints import (
        Constraint,
        coincident,
        configuration_constraint,
        distance,
        motion_constraint,
        no_slip,
        parallel,
        perpendicular,
        rolling,
        touching,
    )
    from kane.model.declarations import Event
    from kane.model.distributed import line_load, pressure_on_disk, pressure_on_rectangle
    from kane.model.field_loads import buoyancy, gravitation, gravity_moment, linear_drag, quadratic_drag
    from kane.model.force_systems import ForceSystem, Wrench, force_system
    from kane.model.friction import dry_friction, friction
    from kane.model.inertia import (
        box,
        central_inertia,
        cylindrical_shell,
        inertia,
        parallel_axis,
        ring,
        rod,
        solid_cone,
        solid_cylinder,
        solid_sphere,
        spherical_shell,
        thin_disk,
    )
    from kane.model.joints.closing import (
        close_ball,
        close_cylindrical,
        close_pin,
        close_planar,
        close_screw,
        close_slider,
        close_universal,
        close_weld,
    )
    from kane.model.joints.contact import Contact, disk_on_plane, sphere_on_plane, torus_on_plane
    from kane.model.joints.crossed_gears import bevel_pair, worm_pair
    from kane.model.joints.gears import gear_pair, rack_and_pinion
    from kane.model.joints.joint import Joint
    from kane.model.joints.lower_pairs import cylindrical, pin, planar, screw, slider, universal, weld
    from kane.model.joints.spherical import ball, free
    from kane.model.loads import (
        Force,
        Gravity,
        Load,
        Torque,
        action_reaction,
        gravity,
        linear_damper,
        linear_spring,
        torque_pair,
        torsional_damper,
        torsional_spring,
    )
    from kane.model.mass import (
        composite,
        inertia_about,
        inertia_matrix,
        inertia_vector,
        mass_center,
        moment_of_inertia,
        product_of_inertia,
        radius_of_gyration,
    )
    from kane.model.principal import Principal, principal
    from kane.model.reactions import auxiliary_speed, reaction
    from kane.model.solids import (
        circular_arc,
        circular_sector,
        ellipsoid,
        frustum,
        half_cylinder,
        hemisphere,
        rectangular_plate,
        right_triangle,
        torus,
        triangular_plate,
    )
    from kane.model.system import System
    from kane.motion.accuracy import Accuracy
    from kane.motion.drives import Signal, signal
    from kane.motion.feedback import sampled
    from kane.motion.load import load_solution
    from kane.motion.run import simulate
    from kane.motion.solution import Solution
    from kane.present.beam_figures import beam_figure, mode_figure
    from kane.present.campbell import campbell_diagram
    from kane.present.checks import Check
    from kane.present.figure import plot
    from kane.present.report import report
    from kane.present.root_locus import root_locus
    from kane.present.version_list import show_versions
    from kane.program.native.machine import Settings
    from kane.space.attitude import Rotation, small_rotation
    from kane.space.frame import Frame
    from kane.space.point import Point
    from kane.space.vector import Dyadic, Vector
    from kane.units.rules import unit_of
    from kane.write.latex import to_latex
    from kane.write.text import to_text

__version__ = "0.1.0.dev0"

logging.getLogger("kane").addHandler(logging.NullHandler())  # a library says nothing unless it is asked to

_NAMES = {
    "analysis.assembly": "Assembled assemble",
    "analysis.method_comparison": "MethodComparison compare_methods",
    "analysis.speed_comparison": "SpeedComparison SpeedSet compare_speeds",
    "analysis.constraint_loads": "ConstraintForces constraint_forces",
    "analysis.solution_branches": "Branch continuation",
    "analysis.impacts": "Impact impact",
    "analysis.inverse_dynamics": "Inverse inverse",
    "analysis.linear": "Linear Mode SecondOrder",
    "analysis.linearization": "Linearizer linearize linearizer",
    "analysis.modes": "NormalModes normal_modes",
    "analysis.point": "OperatingPoint",
    "analysis.stability": "Crossing",
    "analysis.state": "Guess guess",
    "analysis.symbolic": "SymbolicLinear linearize_symbolic",
    "analysis.trimming": "equilibrium trim",
    "dynamics.methods.formulation": "Formulation",
    "dynamics.motions": "Motions motions",
    "dynamics.readings.joint_reactions": "JointReaction",
    "dynamics.readings.noncontributing": "Noncontributing",
    "equations.compiled": "Compiled",
    "equations.derive": "derive",
    "equations.equations": "Equations compile",
    "equations.handle": "Handle",
    "equations.jacobian": "Jacobian",
    "errors":
        "ArgumentError CornerError ExpressionError KaneError KaneWarning MissingAttributeError ModelError ModesWarning "
        "NotAffineError NotFiniteError PotentialError ProgramError ReactionError SimulationError "
        "SingularError SolutionFileError SpaceError SpeedsError StiffeningWarning UnitError ValueMissingError",
    "expr.linear_parts": "affine",
    "expr.count": "Operations count_operations",
    "expr.differentiation": "diff gradient jacobian time_derivative",
    "expr.evaluation": "evaluate free_symbols",
    "expr.matrix": "Matrix",
    "expr.node": "Expr pi",
    "expr.operators":
        "Rational abs acos asin atan atan2 cos cosh exp less log max min sign sin sinh sqrt tan tanh where",
    "expr.solve": "solve_linear",
    "expr.substitution": "substitute",
    "expr.symbols":
        "AuxiliarySpeed Coordinate Input Parameter Rate Reaction Speed State Symbol coordinate coordinates "
        "input parameter parameters speed speeds state time",
    "expr.tables": "Table table",
    "expr.taylor_series": "taylor",
    "interop.sympy": "from_sympy to_sympy",
    "model.beams.beam": "Beam",
    "model.beams.section": "tapered",
    "model.beams.shapes": "ModeShapes mode_shapes",
    "model.bodies": "Particle RigidBody",
    "model.constraints":
        "Constraint coincident configuration_constraint distance motion_constraint no_slip parallel "
        "perpendicular rolling touching",
    "model.declarations": "Event",
    "model.distributed": "line_load pressure_on_disk pressure_on_rectangle",
    "model.field_loads": "buoyancy gravitation gravity_moment linear_drag quadratic_drag",
    "model.force_systems": "ForceSystem Wrench force_system",
    "model.friction": "dry_friction friction",
    "model.inertia":
        "box central_inertia cylindrical_shell inertia parallel_axis ring rod solid_cone solid_cylinder "
        "solid_sphere spherical_shell thin_disk",
    "model.joints.closing":
        "close_ball close_cylindrical close_pin close_planar close_screw close_slider close_universal "
        "close_weld",
    "model.joints.contact": "Contact disk_on_plane sphere_on_plane torus_on_plane",
    "model.joints.crossed_gears": "bevel_pair worm_pair",
    "model.joints.gears": "gear_pair rack_and_pinion",
    "model.joints.joint": "Joint",
    "model.joints.lower_pairs": "cylindrical pin planar screw slider universal weld",
    "model.joints.spherical": "ball free",
    "model.loads":
        "Force Gravity Load Torque action_reaction gravity linear_damper linear_spring torque_pair "
        "torsional_damper torsional_spring",
    "model.mass":
        "composite inertia_about inertia_matrix inertia_vector mass_center moment_of_inertia "
        "product_of_inertia radius_of_gyration",
    "model.principal": "Principal principal",
    "model.reactions": "auxiliary_speed reaction",
    "model.solids":
        "circular_arc circular_sector ellipsoid frustum half_cylinder hemisphere rectangular_plate "
        "right_triangle torus triangular_plate",
    "model.system": "System",
    "motion.accuracy": "Accuracy",
    "motion.drives": "Signal signal",
    "motion.feedback": "sampled",
    "motion.load": "load_solution",
    "motion.run": "simulate",
    "motion.solution": "Solution",
    "present.beam_figures": "beam_figure mode_figure",
    "present.campbell": "campbell_diagram",
    "present.checks": "Check",
    "present.figure": "plot",
    "present.report": "report",
    "present.root_locus": "root_locus",
    "present.version_list": "show_versions",
    "program.native.machine": "Settings",
    "space.attitude": "Rotation small_rotation",
    "space.frame": "Frame",
    "space.point": "Point",
    "space.vector": "Dyadic Vector",
    "units.rules": "unit_of",
    "write.latex": "to_latex",
    "write.text": "to_text",
}  # fmt: skip
"""The public names of each module."""

__getattr__ = _offered(__name__, _NAMES)


def __dir__() -> list[str]:
    return sorted(__all__)


# In reading order: declare, derive, look, run.
__all__ = [
    "coordinates", "coordinate", "speeds", "speed", "parameters", "parameter", "input", "state", "time", "pi", "Rational",
    "sqrt", "sin", "cos", "tan", "asin", "acos", "atan", "atan2", "sinh", "cosh", "tanh", "exp", "log", "abs", "sign",
    "min", "max", "where", "less", "table", "Table",
    "Frame", "Point", "Vector", "Dyadic", "Rotation", "small_rotation",
    "Joint", "pin", "slider", "cylindrical", "screw", "universal", "ball", "free", "planar", "weld",
    "RigidBody", "Particle", "inertia", "rod", "thin_disk", "ring", "solid_sphere", "spherical_shell", "solid_cylinder",
    "cylindrical_shell", "solid_cone", "box", "ellipsoid", "torus", "frustum", "half_cylinder", "hemisphere", "rectangular_plate",
    "right_triangle", "triangular_plate", "circular_sector", "circular_arc", "parallel_axis", "central_inertia",
    "mass_center", "inertia_about", "inertia_matrix", "inertia_vector", "moment_of_inertia", "product_of_inertia",
    "radius_of_gyration", "composite", "principal", "Principal",
    "Beam", "mode_shapes", "ModeShapes", "tapered", "campbell_diagram", "mode_figure", "beam_figure",
    "Force", "Torque", "gravity", "Gravity", "Load", "linear_spring", "linear_damper", "torsional_spring",
    "torsional_damper", "gravitation", "gravity_moment", "buoyancy", "linear_drag", "quadratic_drag", "line_load",
    "pressure_on_rectangle", "pressure_on_disk", "force_system", "ForceSystem", "Wrench",
    "action_reaction", "torque_pair", "friction", "dry_friction",
    "Constraint", "coincident", "distance", "perpendicular", "parallel", "no_slip", "touching", "rolling", "configuration_constraint",
    "motion_constraint",
    "close_pin", "close_slider", "close_cylindrical", "close_screw", "close_universal", "close_ball", "close_planar", "close_weld",
    "disk_on_plane", "sphere_on_plane", "torus_on_plane", "Contact", "gear_pair", "bevel_pair", "worm_pair", "rack_and_pinion",
    "reaction", "JointReaction", "Noncontributing", "auxiliary_speed", "Event",
    "motions", "Motions",
    "System", "derive", "Equations", "compile", "Compiled", "Jacobian", "Handle", "Settings", "assemble", "Assembled", "guess",
    "Guess",
    "signal", "Signal", "sampled", "simulate", "Solution", "load_solution", "Accuracy",
    "linearize", "linearizer", "linearize_symbolic", "Linear", "Linearizer", "SymbolicLinear", "SecondOrder", "Mode",
    "normal_modes", "NormalModes", "impact", "Impact", "constraint_forces", "ConstraintForces", "trim",
    "equilibrium", "OperatingPoint", "continuation", "Branch", "Crossing", "root_locus", "inverse", "Inverse", "compare_speeds",
    "SpeedComparison", "SpeedSet", "compare_methods", "MethodComparison", "Formulation", "plot", "report", "Check",
    "Expr", "Symbol", "Parameter", "Coordinate", "Rate", "Speed", "AuxiliarySpeed", "Reaction", "Input", "State", "Matrix",
    "diff", "gradient", "jacobian", "time_derivative", "affine", "taylor", "substitute", "solve_linear", "evaluate",
    "free_symbols", "unit_of", "count_operations", "Operations", "to_text", "to_latex", "to_sympy", "from_sympy",
    "KaneError", "ExpressionError", "NotAffineError", "SpaceError", "ModelError", "UnitError", "SpeedsError", "ReactionError",
    "PotentialError", "SingularError", "ValueMissingError", "SimulationError", "CornerError", "SolutionFileError", "ProgramError",
    "ArgumentError", "MissingAttributeError", "NotFiniteError", "KaneWarning", "StiffeningWarning",
    "ModesWarning", "show_versions", "__version__",
]  # fmt: skip

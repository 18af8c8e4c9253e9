# SPDX-License-Identifier: BSD-3-Clause
"""Representations for notebooks, entered into the tables of `kane.show` when a notebook first displays an object.

No representation raises: `show` guards the whole, `typeset.either` its parts.
"""

from kane import show
from kane.analysis.assembly import Assembled
from kane.analysis.comparison import MethodComparison, SpeedComparison
from kane.analysis.linear import Linear, Mode, NormalModes
from kane.dynamics.formalisms import Formulation
from kane.dynamics.lazy import LazyMapping
from kane.dynamics.motions import Motions
from kane.dynamics.readings.energy import Integral
from kane.dynamics.readings.potential import FoundPotential
from kane.equations.compiled import Compiled, Handle
from kane.equations.equations import Equations
from kane.equations.state import State
from kane.errors import Attributes
from kane.expr.matrix import Matrix
from kane.expr.node import Expr
from kane.expr.symbols import Symbols
from kane.model.beams.beam import Beam
from kane.model.bodies import Particle, RigidBody
from kane.model.constraints import Constraint
from kane.model.force_systems import ForceSystem, Wrench
from kane.model.loads import Load
from kane.model.mass import Principal
from kane.model.system import System
from kane.motion.solution.solution import Solution
from kane.present.notebook import record_tables as records
from kane.present.notebook.declared import equations_html, system_html
from kane.present.notebook.typeset import dyadic, expression, matrix, matrix_words, vector
from kane.space.attitude import Rotation
from kane.space.frame import Frame, Point
from kane.space.vector import Dyadic, Vector

show.LATEX.update(
    {
        Expr: lambda e: expression(e).dollars("An expression"),
        Matrix: lambda m: matrix(m).dollars(f"A {matrix_words(m)},"),
        Vector: lambda v: vector(v).dollars("A vector"),
        Dyadic: lambda d: dyadic(d).dollars("A dyadic"),
        Rotation: records.rotation_latex,
        show.Named: lambda n: records.named_formulas(n).dollars("Expressions"),
        FoundPotential: lambda v: expression(v.value).dollars("A potential energy"),
        Integral: lambda i: expression(i.value).dollars("An integral"),
    }
)
show.HTML.update(
    {
        System: system_html,
        Equations: equations_html,
        Handle: lambda h: records.routine_html(h.program, h.routine),
        Compiled: lambda c: records.program_html(c.program, c.operations),
        Solution: records.solution_html,
        Linear: records.linear_html,
        SpeedComparison: records.comparison_html,
        Principal: records.principal_html,
        Motions: records.motions_html,
        ForceSystem: records.force_system_html,
        Wrench: records.wrench_html,
        MethodComparison: records.comparison_html,
        Formulation: records.formulation_html,
        Frame: records.frame_html,
        Point: records.point_html,
        RigidBody: records.body_html,
        Particle: records.body_html,
        Beam: records.body_html,
        Load: records.load_html,
        Constraint: records.constraint_html,
        State: records.state_html,
        Assembled: records.assembled_html,
        Mode: records.mode_html,
        NormalModes: records.normal_modes_html,
        Symbols: records.symbols_html,
        tuple: records.listing_html,
        LazyMapping: records.mapping_html,
        Attributes: records.record_html,
    }
)

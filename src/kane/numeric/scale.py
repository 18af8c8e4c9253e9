# SPDX-License-Identifier: BSD-3-Clause
"""The tolerances of the library, each named by what it decides; a module with one of its own says there why none of these does.

All are shares of a size that belongs to the question (the largest entry, the terms of a sum, a span), so that units do not matter.
Doubles carry sixteen digits; each group says how many of them its numbers have lost before they are compared.
"""

from kane.expr.constants import EPS as EPS

# Zero: the number beside those it was computed from.
LAST_DIGIT = 1e-15
"""A cosine, an angle, or a residual beside its terms that no further operation improves: few spacings of numbers at 1."""
ROUNDED = 1e-13
"""An entry beside the largest of its matrix, a coefficient or residual beside its terms: some hundred roundings add up to it."""
ROUNDED_CHAIN = 1e-12
"""A measure number beside the largest, where it came through products along a chain of bodies."""
ROUNDED_SUM = 1e-11
"""A sum beside its terms, each a long expression, at all of several states drawn at random."""
UNRELATED = 1e-9
"""A slope or share through which one quantity might depend on another: below, it does not, in the digits a difference leaves."""
ROUNDED_ROOT = 1e-7
"""What comes through a root, a singular position or a double eigenvalue: half of the digits are gone."""

# Equal: two numbers that came different ways, and numbers that were typed.
EQUAL = 1e-9
"""Two numbers beside the larger, computed in two ways or at two places where the same is expected of them."""
DECLARED = 1e-9
"""What a declaration must satisfy (perpendicular, of unit length, triangle inequality): constants have ten digits."""
GIVEN = 1e-8
"""The same of direction cosines, Euler parameters and whole states: files give eight digits of them."""
SIX_DIGITS = 1e-6
"""Agreement of what was solved for, integrated or differentiated by differences: six digits are right in what may be shown."""

# Closing: the residual of a constraint beside its terms.
CLOSED_FULLY = 1e-13
"""Residual at which Newton's steps end: what is left is rounding's."""
CLOSED = 1e-10
"""Residual at which a configuration counts as closed, also where convergence is linear because branches meet."""
SOLVED = 1e-9
"""Residual at which conditions count as met that are solved for among values: trims, branches of solutions."""
CLOSED_NEARLY = 1e-6
"""The same where nothing closes better: near a singular position f falls with the square of what is missing."""
ONE_POSITION = 1e-5
"""Distance up to which two closed configurations are one: at a dead centre steps end a root of `CLOSED` from it."""
FIXED_SHARE = 1e-12
"""Singular value of a Jacobian beside the largest, below which Newton's steps move nothing along it."""

# Rank: a singular value beside the largest, or a pivot beside its candidates, of a balanced matrix.
MOTION_RANK = 1e-4
"""Constraints along a motion. Where a linkage comes through a position at which they lose rank, what rounding leaves of f becomes f/σ
in q and f/σ² in u, however short the steps: f = c ≠ 0 does not go through there, but turns off. Combinations that are as small
everywhere are enlarged before (`Mixed`): nothing turns off there."""
SURE_RANK = 1e-5
"""Rows at a state above this are independent without a second look by elimination."""
NEAR_SINGULAR = 1e-6
"""Reciprocal condition at which speeds no longer follow from others: by chance no configuration lies so near to a singular one, and
beside a false pole of the speeds the derivatives lose half as many digits again as the solution."""
DERIVE_RANK = 1e-8
"""Constraints at a configuration that Newton's method has closed: which of them hold, and which follow from the others."""
STATE_RANK = 1e-9
"""Whether conditions determine the values that are solved for; seven digits of these would be right."""
SPEEDS_RANK = 1e-10
"""The definitions of speeds at a point drawn at random, where nothing is small but what vanishes everywhere."""
INVERSE_RANK = 1e-11
"""The equations of inverse dynamics; five digits of the unknowns would be right."""
SOLVE_RANK = 1e-12
"""Any other square matrix that is solved with; four digits of the solution would be right."""
TAKES_PART = 1e-6
"""Share of its largest entry above which an entry of a null vector is not zero."""

# Dependent speeds: the quality of a choice, 1/‖B⁻¹‖ over ‖A‖, 1 at best.
PIVOT = 0.15
"""Share of the largest entry left that a pivot must have: growth by elimination stays within one digit a few rows on."""
POOR = 0.02
"""Quality below which other dependent speeds are sought: their accelerations have lost two digits."""
UNUSABLE = 1e-3
"""Quality below which a state between two steps is read off with other dependent speeds than it was stepped with."""
BETTER = 4.0
"""How many times better another choice must be: changes cost time, and must not go to and fro."""

# Time: a distance in time beside the span, the step, or the times themselves.
SAME_TIME = 1e-12
"""Two times are one: an event is located to this share of a step, phases below it are none."""
NEAR_TIME = 1e-9
"""Two times of different origin are one: a breakpoint and a jump, an event and the end of a span."""
SOON = 1e-6
"""After this share of a step a quantity shows by its slope where it is going."""
LATER = 1e-3
"""After this share of a step it shows by its value."""

# Motion: what a motion may miss.
CHANGES_SIDE = 1e-6
"""Share of its usual size below which the quantity of a switch or event is at its threshold: it is located no better."""
LEAPS = 1e-6
"""Share of its range by which a function that jumps differs from the integral of its derivative, or on both sides of an instant."""

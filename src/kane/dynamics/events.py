# SPDX-License-Identifier: BSD-3-Clause
"""Events that every system watches: the end of slip, Painlevé's case, and singular kinematics."""

from collections.abc import Sequence
from dataclasses import replace

from kane.dynamics.solved import Solved
from kane.expr.build import div
from kane.expr.evaluate import free_symbols, is_constant_in_time
from kane.expr.node import ONE, Expr, postorder
from kane.expr.ops import DIV, SQRT
from kane.expr.solve import determinant
from kane.expr.symbols import Reaction, Speed
from kane.kinematics.speeds import Speeds
from kane.model.declarations import Event
from kane.model.loads import Load

SLIP_THRESHOLD = 1e-4
"""Speed (m/s) below which a load along a slip direction v/|v| is taken to have lost it."""

PAINLEVE_THRESHOLD = 1e-3
"""Share of its frictionless value below which the reactions' determinant counts as lost: they grow without bound towards 0."""

SINGULAR = "singular kinematics"
"""How the name of the event begins that ends a motion where W does not exist."""

_LARGEST_WATCHED = 3

_STOPS_SLIPPING = (
    f"the slip speed of the {{}} fell below {SLIP_THRESHOLD:g}: rolling sets in, and the direction that the load takes from the slip "
    "is lost. The sliding model ends here"
)
_OPENS = (
    "the {0} takes its size from {1}, which must press: at {1} = 0 the contact opens, and the model ends here. If it presses where it "
    "is negative, declare it along the opposite direction"
)
_HAS_NO_RATES = (
    "W of q' = W u + X divides by {}, which vanishes here. Choose coordinates that are regular along this motion (another sequence of "
    "angles, Euler parameters), or speeds that need no such division"
)
_HAS_NO_REACTIONS = (
    "the friction multiplies the reactions that it depends on so strongly that they have no unique finite solution. Lower the "
    "friction coefficient, or model the contact as compliant"
)


def watched_events(solved: Solved) -> tuple[Event, ...]:
    """Painlevé's case, the ends of slip and of the kinematics, and the events that the system declares."""
    derived = solved.regular
    events = (
        *painleve_events(solved),
        *slip_events(derived.declared_loads),
        *singular_events(derived.kinematical),
        *(replace(e, quantity=derived.kinematical.in_speeds(e.quantity, {})) for e in derived.system.events),
    )
    quantities = solved.written(e.quantity for e in events)
    return tuple(replace(e, quantity=x) for e, x in zip(events, quantities, strict=True))


def slip_events(loads: Sequence[Load]) -> tuple[Event, ...]:
    """For each load along a slip direction v/|v|: the end of slip, and, where it holds a reaction, the loss of contact."""
    slips: dict[Expr, str] = {}
    contacts: dict[Expr, str] = {}
    for load in loads:
        below = postorder(x for _, v in (*load.forces, *load.torques) for x in v.scalars())
        lengths = [n.args[1] for n in below if n.op is DIV and n.args[1].op is SQRT]
        speeds = [e for e in lengths if any(isinstance(s, Speed) for s in free_symbols([e]))]
        for speed in speeds:
            slips.setdefault(speed, load.name)
        if speeds:
            for s in below:
                if isinstance(s, Reaction):
                    contacts.setdefault(s, load.name)
    return (
        *(
            Event(f"onset of rolling ({name})", speed, SLIP_THRESHOLD, -1, message=_STOPS_SLIPPING.format(name))
            for speed, name in slips.items()
        ),
        *(
            Event(f"contact lost ({reaction} = 0)", reaction, direction=-1, message=_OPENS.format(name, reaction))
            for reaction, name in contacts.items()
        ),
    )


def singular_events(speeds: Speeds) -> tuple[Event, ...]:
    """Each pivot of W through zero: there the coordinates' rates are not determined by the speeds."""
    return tuple(
        Event(f"{SINGULAR} ({pivot} = 0)", pivot, message=_HAS_NO_RATES.format(pivot))
        for pivot in dict.fromkeys(speeds.pivots)
        if not is_constant_in_time([pivot])
    )


def painleve_events(solved: Solved) -> tuple[Event, ...]:
    """The determinant of what the reactions are multiplied by, over its value without the loads they enter.

    It is 1 without friction. Where it vanishes the reactions have no finite solution; beyond, more pressing needs less force
    (Painlevé 1895). Watched for up to three reactions.
    """
    matrix, bare = solved.reaction_matrix, solved.bare_reaction_matrix
    count = matrix.shape[0]
    if not 1 <= count <= _LARGEST_WATCHED:
        return ()
    ratio = div(determinant(matrix.rows), determinant(bare.rows))
    if ratio is ONE:
        return ()
    return (Event("Painlevé's case", ratio, PAINLEVE_THRESHOLD, -1, message=_HAS_NO_REACTIONS),)

# SPDX-License-Identifier: BSD-3-Clause
"""Events that every system watches: the end of slip, Painlevé's case, and singular kinematics."""

from collections.abc import Sequence
from dataclasses import replace

from kane.dynamics.solved import Solved
from kane.expr.build import div
from kane.expr.evaluation import free_symbols, is_constant_in_time
from kane.expr.node import ONE, Expr
from kane.expr.solve import determinant
from kane.expr.symbols import Reaction, Speed
from kane.kinematics.speeds import Speeds
from kane.model.declarations import Event
from kane.model.loads import Load

SLIPS = 1e-4
"""Share of the largest slip of a motion below which a contact no longer slides, unless its friction says from which speed on."""
PAINLEVE_THRESHOLD = 1e-3
"""Share of its frictionless value below which the reactions' determinant counts as lost: they grow without bound towards 0."""

SINGULAR = "singular kinematics"
"""How the name of the event begins that ends a motion where W does not exist."""

_LARGEST_WATCHED = 3

_STOPS_SLIPPING = (
    "the slip speed of the {0} fell below {1}: {2} sets in, and the direction that the load takes from the slip "
    "is lost. The sliding model ends here; with smooth= the friction goes on, and creeps"
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


class SlipEnd(Event):
    """The end of a slip, at its threshold or, where that is zero, at a share of the largest slip of the motion."""

    __slots__ = ()

    @property
    def by_share(self) -> bool:
        """Whether a share of the largest slip ends it."""
        return self.threshold == 0


class KinematicsEnd(Event):
    """A pivot of W through zero."""

    __slots__ = ()


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
    """The ends of slip of loads that declare friction; and of loads that a reaction and a speed make, the loss of contact.

    Such a load takes its size from the reaction, declared as friction or not: where that pulls, the load would feed the motion.
    """
    slips: dict[Expr, Event] = {}
    contacts: dict[Expr, str] = {}
    for load in loads:
        held = free_symbols(x for _, v in (*load.forces, *load.torques) for x in v.scalars())
        own = load.slip
        if own is not None and own.speed is not None:
            least = "a ten-thousandth of its largest" if own.threshold is None else f"{own.threshold:g}"
            onset = "rolling" if own.rolls else "sticking"
            told = _STOPS_SLIPPING.format(load.name, least, onset)
            event = SlipEnd(f"onset of {onset} ({load.name})", own.speed, own.threshold or 0.0, -1, message=told)
            slips.setdefault(own.speed, event)
        pressing = own.presses if own is not None else held if any(isinstance(s, Speed) for s in held) else ()
        for s in pressing:
            if isinstance(s, Reaction):
                contacts.setdefault(s, load.name)
    return (
        *slips.values(),
        *(
            Event(f"contact lost ({reaction} = 0)", reaction, direction=-1, message=_OPENS.format(name, reaction))
            for reaction, name in contacts.items()
        ),
    )


def singular_events(speeds: Speeds) -> tuple[Event, ...]:
    """Each pivot of W through zero: there the coordinates' rates are not determined by the speeds."""
    return tuple(
        KinematicsEnd(f"{SINGULAR} ({pivot} = 0)", pivot, message=_HAS_NO_RATES.format(pivot))
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

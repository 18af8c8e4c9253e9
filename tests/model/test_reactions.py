# SPDX-License-Identifier: BSD-3-Clause
"""Reactions and auxiliary speeds as declarations: leaves that change nothing, with a place and a direction."""

from __future__ import annotations

import pytest

import kane as kn
from kane.model import cut_of

N = kn.Frame("N")
O = kn.Point("O", fixed_in=N)
q = kn.coordinate("q")
A = N.rotate("A", q, N.z)
P = O.at("P", 0)


def test_a_reaction_is_a_leaf_with_a_place():
    force, torque = kn.reaction("F", at=P, along=N.x), kn.reaction("T", frame=A, along=A.x)
    assert isinstance(force, kn.Reaction)
    assert (cut_of(force).at, str(cut_of(force).along), force.unit) == (P, "N.x", "N")
    assert (cut_of(torque).at, str(cut_of(torque).along), torque.unit) == (A, "A.x", "N*m")


def test_declared_twice_it_is_the_same():
    assert kn.reaction("F", at=P, along=N.x) is kn.reaction("F", at=P, along=N.x)
    assert kn.reaction("F", at=P, along=N.x) is not kn.reaction("F", at=P, along=N.y)


def test_bare_reaction_and_explicit_speed():
    bare = kn.reaction("F")
    assert cut_of(bare) is None
    speed = kn.auxiliary_speed("ua", at=P, along=N.y)
    assert isinstance(speed, kn.AuxiliarySpeed)
    assert (cut_of(speed).at, speed.unit) == (P, "m/s")
    assert kn.auxiliary_speed("wa", frame=A, along=N.y).unit == "rad/s"


def test_the_rate_of_a_reaction_has_no_name():
    with pytest.raises(kn.ExpressionError, match="time derivative of the reaction"):
        _ = (2 * kn.reaction("F", at=P, along=N.x)).dt


@pytest.mark.slow
@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: kn.reaction("F", at=P, frame=A, along=N.x), "got both"),
        (lambda: kn.reaction("F", along=N.x), "got neither"),
        (lambda: kn.reaction("F", at=A, along=N.x), "at=Point or frame=Frame"),
        (lambda: kn.reaction("F", frame=P, along=N.x), "at=Point or frame=Frame"),
        (lambda: kn.reaction("F", at=O, along=N.x), r"near side.*Make the cut explicit: O.at\(…\)"),
        (lambda: kn.reaction("F", frame=N, along=N.x), r"near side.*N.rotate\(…\)"),
        (lambda: kn.reaction("F", at=P.fixed_in(A, "Q", A.x), along=N.x), "got Q, a particle"),
        (lambda: kn.reaction("F", at=P), "along=unit vector"),
        (lambda: kn.reaction("F", at=P, along=0 * N.x), "along=unit vector"),
        (lambda: kn.reaction("F", at=P, along=2 * N.x), "unit vector.*length 2"),
        (lambda: kn.reaction("F", at=P, along=N.x + A.x), "unit vector"),
        (lambda: kn.reaction("F", at=P, along="x"), "along=unit vector"),
        (lambda: kn.auxiliary_speed("ua", at=O, along=N.x), "the auxiliary speed 'ua'"),
        (lambda: kn.auxiliary_speed("ua"), "got neither"),
    ],
)
def test_errors(make, message):
    with pytest.raises(kn.ReactionError, match=message):
        make()

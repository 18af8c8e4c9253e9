# SPDX-License-Identifier: BSD-3-Clause
"""What is said of operands that go with no vector: a scalar in a sum, a vector as a divisor, a frame in the place of its axis."""

from kane import expect
from kane.errors import SpaceError, cut
from kane.space.rotation import Basis, connected


def scalar_beside(verb: str, vector: object, came: object, frame: str) -> SpaceError:
    """A scalar in a sum of vectors; `frame` is the name of one along which it may point."""
    return SpaceError(
        f"Expected a vector to {verb} {cut(vector)}, got the scalar {cut(came)}. Give it a direction, such as "
        f"{cut(came, 20)}*{frame}.x."
    )


def divided_by(vector: object) -> SpaceError:
    """A vector or dyadic as a divisor."""
    return SpaceError(
        f"Expected a scalar divisor, got {cut(vector)}. Divide by a magnitude, v.magnitude(), or a measure number, v.dot(N.x)."
    )


def raised(vector: object) -> SpaceError:
    """A power of a vector."""
    return SpaceError(f"Expected a scalar to raise to a power, got the vector {cut(vector)}. Its square is v.dot(v).")


def not_a_vector(product: str, came: object) -> SpaceError:
    """What came as the other vector of a product such as "a.dot(b)"."""
    if hasattr(came, "dyads"):
        cure = "Write dyadic.dot(vector)."
    elif isinstance(came, Basis):
        cure = f"Take one of its axes, such as {came.name}.x."
    else:
        cure = "A product with a scalar is a * b."
    return SpaceError(
        f"Expected a vector in {product}, got {came.name if isinstance(came, Basis) else cut(came)}. {cure}"
    )


def check_connected(f: Basis, g: Basis) -> None:
    """A SpaceError unless both are frames, of one tree."""
    expect.instance(g, Basis, "a frame, along whose axes or in which a vector is asked for", error=SpaceError)
    if not connected(f, g):
        raise SpaceError(
            f"Expected frames of one tree, got {f.name} and {g.name}, which have no common root. Make one from the other "
            "with rotate(...)."
        )


def not_a_dyadic(came: object) -> SpaceError:
    """What came in a sum of dyadics."""
    return SpaceError(
        f"Expected a dyadic in a sum of dyadics, got {cut(came)}. A moment of inertia about an axis is I * e.outer(e)."
    )

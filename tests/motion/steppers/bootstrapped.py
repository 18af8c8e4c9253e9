# SPDX-License-Identifier: BSD-3-Clause
"""Dense output of order 7 for Tsitouras and Papakostas's pair, worked out anew in 50 digits.

As Enright, Jackson, Nørsett & Thomsen (*Interpolants for Runge–Kutta formulas*, ACM Trans. Math. Software 12 (1986) 193–218) do it:
weights of an interpolant are linear in the conditions of order, Σ_j b_j(θ) Φ_j(t) = θ^|t| / γ(t) for each rooted tree t. Those of
order 6 can be met by the pair's own stages and f at the end of the step at four shares θ alone: 0, 1 and (7 ± √7)/14. So the first
stage more stands at one of these; with its rate order 6 can be met anywhere, and two more such stages give order 7 along the step.

What conditions leave free comes nearest to those of the next order, each tree by 1/σ(t), and is least where these leave it free too.
`python -m tests.motion.steppers.bootstrapped` prints the table of `kane/motion/steppers/tsitpap8.py`.
"""

from fractions import Fraction
from pathlib import Path

from mpmath import mp  # type: ignore[import-untyped]

from tests.motion.steppers.rooted import density, nodes, symmetry, trees

_SOURCE = Path(__file__).with_name("tsitpap8.txt")
_DIGITS = 50
_NOTHING, _LEAST = mp.mpf(10) ** -35, mp.mpf(10) ** -25
"""What is zero after elimination; how much, beside the conditions of the next order, the size of weights counts."""
_ORDER = 7
_UNUSED = range(1, 5)
"""Stages that b leaves out, of low order."""


def source():
    """c, the rows of a, b and b less the weights of order 7, as fractions."""
    lines = [line for line in _SOURCE.read_text(encoding="utf-8").splitlines() if not line.startswith("#")]
    c, *a, b, errors = [[Fraction(x) for x in line.split()] for line in lines]
    return c, a, b, errors


def nested(q):
    """θ^q in θ, θ(1−θ), θ²(1−θ), θ²(1−θ)², …, as many as there are up to degree q, and zeros up to degree 8."""
    polynomials = [[0, 1]]
    for k in range(1, _ORDER + 1):
        last = polynomials[-1]
        polynomials.append([0, *last] if k % 2 == 0 else [x - y for x, y in zip([*last, 0], [0, *last], strict=True)])
    left, found = [0] * q + [1], [0] * (_ORDER + 1)
    for k in reversed(range(q)):
        found[k] = Fraction(left[k + 1], polynomials[k][k + 1])
        for j, x in enumerate(polynomials[k]):
            left[j] -= found[k] * x
    return found


def solved(rows, right):
    """A solution of linear equations, of which there may be more than needed, and what may be added to it: by Gauss and Jordan."""
    count, rows = len(rows[0]), [[*row, r] for row, r in zip(rows, right, strict=True)]
    pivots = []
    while len(pivots) < count:
        free = [j for j in range(count) if j not in pivots]
        size, i, j = max((abs(rows[i][j]), i, j) for i in range(len(pivots), len(rows)) for j in free)
        if size < _NOTHING:
            break
        at = len(pivots)
        rows[at], rows[i] = rows[i], rows[at]
        rows[at] = [x / rows[at][j] for x in rows[at]]
        for other in range(len(rows)):
            if other != at and rows[other][j]:
                share = rows[other][j]
                rows[other] = [x - share * y for x, y in zip(rows[other], rows[at], strict=True)]
        pivots.append(j)
    assert max((abs(row[-1]) for row in rows[len(pivots) :]), default=0) < _NOTHING, (
        "conditions that contradict each other"
    )
    one = [mp.mpf(0)] * count
    for row, j in zip(rows, pivots, strict=False):
        one[j] = row[-1]
    free = [j for j in range(count) if j not in pivots]
    more = [[-rows[pivots.index(j)][f] if j in pivots else mp.mpf(j == f) for j in range(count)] for f in free]
    return one, more


def dot(a, b):
    return mp.fsum(x * y for x, y in zip(a, b, strict=True))


class Conditions:
    """Those of all trees up to an order and those of the next one, for weights of the stages there are."""

    def __init__(self, a, order):
        self.order, self.count, self.phi = order, len(a), {}
        self.a = [[*row, *[mp.mpf(0)] * (len(a) - len(row))] for row in a]
        self.used = [j for j in range(self.count) if j not in _UNUSED]
        self.met = [t for n in range(1, order + 1) for t in trees(n)]
        self.near = trees(order + 1)

    def weights(self, tree):
        """Φ: what each stage gives of the derivative that belongs to a tree."""
        if tree not in self.phi:
            branches = [[dot(row, self.weights(branch)) for row in self.a] for branch in tree]
            self.phi[tree] = (
                [mp.fprod(column) for column in zip(*branches, strict=True)] if tree else [mp.mpf(1)] * self.count
            )
        return self.phi[tree]

    def rows(self, found):
        return [[self.weights(t)[j] / symmetry(t) for j in self.used] for t in found]

    def nearest(self, share):
        """Weights w with Σ w Φ(t) = share(|t|) / γ(t), and nearest to it for the next order."""
        one, more = solved(self.rows(self.met), [share(nodes(t)) / (density(t) * symmetry(t)) for t in self.met])
        next_rows = self.rows(self.near)
        right = [share(self.order + 1) / (density(t) * symmetry(t)) for t in self.near]
        if more:
            miss = [r - dot(row, one) for r, row in zip(right, next_rows, strict=True)]
            change = [[dot(row, z) for row in next_rows] for z in more]
            ways = list(zip(change, more, strict=True))
            normal = mp.matrix([[dot(x, y) + _LEAST * dot(z, v) for y, v in ways] for x, z in ways])
            gain = mp.lu_solve(normal, mp.matrix([dot(x, miss) - _LEAST * dot(z, one) for x, z in ways]))
            one = [x + dot(gain, column) for x, column in zip(one, zip(*more, strict=True), strict=True)]
        full = dict(zip(self.used, one, strict=True))
        return [full.get(j, mp.mpf(0)) for j in range(self.count)]


def own_rows():
    """Weights of the pair's stages and of y'."""
    _, a, b, _ = source()
    return [[mp.mpf(x.numerator) / x.denominator for x in row] for row in ([], *a, b)]


def dense():
    """Each later stage's c and row, and what stands at φ_3, φ_4, … in dense output."""
    with mp.workdps(_DIGITS):
        rows = own_rows()
        nodes_more = [(7 - mp.sqrt(7)) / 14, mp.mpf(1) / 2, mp.mpf(7) / 10]
        later = []
        for at in nodes_more:
            row = Conditions(rows, _ORDER - 1).nearest(lambda q, at=at: at**q)
            later.append((at, row))
            rows.append(row)
        powers = {
            q: [mp.mpf(x.numerator) / x.denominator for x in map(Fraction, nested(q))] for q in range(1, _ORDER + 2)
        }
        conditions = Conditions(rows, _ORDER)
        return later, [conditions.nearest(lambda q, k=k: powers[q][k]) for k in range(3, _ORDER)]


def _printed(rows):
    return "\n".join("    " + " ".join("0" if not x else repr(float(x)) for x in row) for row in rows)


def main() -> None:
    """Print the numbers."""
    c, a, b, errors = source()
    later, ends = dense()
    for name, rows in (
        ("C", [c]),
        ("A", a),
        ("B", [b]),
        ("ERRORS", [[*errors, 0]]),
        ("LATER", [[at, *row] for at, row in later]),
    ):
        print(f"_{name}\n{_printed(rows)}")
    print(f"_DENSE\n{_printed(ends)}")


if __name__ == "__main__":
    main()

# SPDX-License-Identifier: BSD-3-Clause
"""Random loops that are known to close: `kn.assemble` closes all of them, from what leaves nothing free."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.linalg
from hypothesis import given

import kane as kn
from kane.dynamics import manifold
from tests.examples import examples
from tests.laws.test_random_loops import KINDS
from tests.oracles.mechanism import Mechanism
from tests.oracles.mechanism_draw import mechanisms
from tests.oracles.mechanism_kane import Asked, to_kane


def dependent(system: kn.System, q: dict[kn.Coordinate, float]) -> set[kn.Coordinate]:
    """Coordinates that the constraints give at q, by pivoted columns of ∂f/∂q."""
    defaults = {p: p.default for p in system.parameters}
    gradient = np.asarray(kn.evaluate(manifold(system).gradient, q | defaults), dtype=float)
    triangle, columns = scipy.linalg.qr(gradient, mode="r", pivoting=True)
    size = np.abs(np.diag(triangle))
    return {system.coordinates[k] for k in columns[: int((size > 1e-9 * size[0]).sum())]}


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::kane.KaneWarning")
@pytest.mark.parametrize(("planar", "loops"), KINDS)
@pytest.mark.parametrize("joined", [False, True])
def test_a_loop_that_closes_is_closed(planar: bool, loops: int, joined: bool) -> None:
    @examples(0.01, 2)
    @given(mechanisms(planar, loops))
    def check(m: Mechanism) -> None:
        model = to_kane(m, Asked(joined=joined))
        if not model.system.holonomic:
            return
        q = model.q()
        given_ = {s: v for s, v in q.items() if s not in dependent(model.system, q)}
        found = kn.assemble(kn.derive(model.system), q=given_)
        assert found.residual < 1e-10
        assert found.branch
        near = kn.assemble(kn.derive(model.system), q={s: v if s in given_ else kn.guess(v) for s, v in q.items()})
        assert [near.q[s] for s in q] == pytest.approx(list(q.values()), abs=1e-6)

    check()

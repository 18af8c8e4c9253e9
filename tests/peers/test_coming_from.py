# SPDX-License-Identifier: BSD-3-Clause
"""The example of the page for those who come from MuJoCo: its MJCF and its listing have the same accelerations."""

from __future__ import annotations

import re

import numpy as np

from tests.docs.snippets import ROOT
from tests.peer import require

mujoco = require("mujoco")

PAGE = (ROOT / "docs" / "coming_from" / "mujoco_drake.md").read_text(encoding="utf-8")


def test_mujoco_has_the_accelerations_that_the_page_prints():
    """What the listing prints is tested with all pages; here MuJoCo's own reading of the MJCF beside it gives it, too."""
    (mjcf,) = re.findall(r"```xml\n(.*?)```", PAGE, re.DOTALL)
    printed = re.search(r"```text\n(-?[\d.]+) (-?[\d.]+)\n```", PAGE)
    state = re.search(r"q=\[([^]]*)\], u=\[([^]]*)\], inputs=\{T: ([\d.]+)\}", PAGE)
    assert printed is not None
    assert state is not None
    model = mujoco.MjModel.from_xml_string(mjcf)
    data = mujoco.MjData(model)
    data.qpos[:] = [float(x) for x in state[1].split(",")]
    data.qvel[:] = [float(x) for x in state[2].split(",")]
    data.ctrl[:] = float(state[3])
    mujoco.mj_forward(model, data)
    assert np.allclose(data.qacc, [float(x) for x in printed.groups()], rtol=0, atol=1e-6)

# SPDX-License-Identifier: BSD-3-Clause
"""Further states where systems, equations and motions are shown."""

import json

import pytest

import kane as kn
from kane.gallery import muscle_arm
from kane.present import chapters_of, plots
from tests.cli.command import kane

EOM = kn.derive(muscle_arm.system())


def test_the_last_step_holds_their_rates():
    step = EOM.steps[6]
    name, value = step.items[-1]
    assert name == "a'"
    assert value is EOM.state_rates[0]
    assert step.text.endswith("The further states have their own rates.")
    last = chapters_of(EOM)[6]
    assert last.text.endswith("The further states have their own rates.")
    assert r"\dot{a}" in [f.left for f in last.formulas]


@pytest.mark.slow
def test_reports_and_notebooks_name_them(tmp_path):
    sol = kn.simulate(EOM, (0, 1), **muscle_arm.START, samples=11)
    page = kn.report(EOM, tmp_path / "arm.html", solution=sol).read_text(encoding="utf-8")
    assert "Further states" in page
    assert "activation of the muscle" in page
    assert "states" in [plot.name for plot in plots(sol)]
    assert "activation" in EOM.system._repr_html_()
    assert "1 further state" in EOM._repr_html_()
    assert len(kn.plot(sol).axes) == len(["coordinates", "speeds", "states", "energy"])


def test_commands_take_them():
    told = kane("check", "muscle_arm").stdout
    assert "Further states (1)" in told
    what = json.loads(kane("check", "muscle_arm", "--json").stdout)
    assert what["states"][0]["name"] == "a"
    low, high = (
        json.loads(kane("simulate", "muscle_arm", "--t1", 0.1, "--state", f"a={a}", "--json").stdout) for a in (0, 1)
    )
    assert low["ok"]
    assert high["ok"]
    assert low != high
    kane("simulate", "muscle_arm", "--state", "b=1", code=2)


@pytest.mark.parametrize("method", ["lagrange", "newton-euler"])
def test_other_methods_have_none(method):
    with pytest.raises(kn.ModelError, match=r"without further states .* got a, which"):
        EOM.by(method)
    assert EOM.by("kane").state == EOM.state

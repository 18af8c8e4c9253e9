# SPDX-License-Identifier: BSD-3-Clause
"""The commands print what the library computes."""

from __future__ import annotations

import csv
import re
import runpy
import zipfile
from itertools import pairwise
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from typer.testing import CliRunner

import kane as kn
from kane.cli import STARTS, app
from kane.gallery import GALLERY, load
from kane.motion import emit_simulator_wasm
from kane.program import targets
from tests.cli.command import HEAD, SPRING, from_json, kane, line, written
from tests.present.page import Page


@pytest.fixture(autouse=True)
def _here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


@pytest.fixture(scope="module")
def top():
    return kn.derive(load("spinning_top").system())


def test_check_says_what_the_model_is(top):
    said = kane("check", "spinning_top").stdout
    assert said.startswith("spinning_top: heavy symmetrical top\n")
    for part in ("Bodies (1)", "Coordinates (3)", "Speeds (3)", "Loads (1)", "Parameters (5)"):
        assert part in said
    assert re.search(r"^  J +0.0008 +kg\*m\^2 +moment of inertia about the axis$", said, re.MULTILINE)
    assert f"{top.operations.total} operations: {top.operations.state} with the state" in said
    assert "No error found" in said
    assert "Warnings" not in said
    found = from_json("check", "spinning_top")
    assert {p["name"]: p["default"] for p in found["parameters"]} == {p.name: p.default for p in top.parameters}
    assert [u["definition"] for u in found["speeds"]] == ["psi'", "theta'", "phi'"]
    assert found["operations"]["total"] == top.operations.total
    assert found["operations"]["by_operation"] == dict(top.operations.by_operation)


def test_check_says_where_a_reaction_acts():
    (normal,) = from_json("check", "rolling_disk")["reactions"]
    assert (normal["name"], normal["unit"], normal["at"], normal["along"]) == ("N_z", "N", "P", "N.z")
    assert "at P, along N.z" in kane("check", "rolling_disk").stdout


def test_check_warns_of_what_is_missing(tmp_path):
    file = written(tmp_path, SPRING)
    warned = from_json("check", file)["warnings"]
    assert warned[0].startswith("No default for k:")
    assert "--q x=… --q y=… --u u_x=… --u u_y=…" in warned[1]
    assert warned[0] in line(kane("check", file).stdout)


def test_check_fails_where_the_start_is_singular(tmp_path):
    text = "from kane.gallery.spherical_pendulum import system\n"
    text += "START = {'q': {'phi': 0, 'theta': 0}, 'u': {'u_phi': 1, 'u_theta': 1}}\n"
    assert "finite rates at the start, got none for u_phi'" in line(
        kane("check", written(tmp_path, text), code=1).stderr
    )


def test_check_passes_where_other_speeds_are_dependent_at_the_start(tmp_path):
    """A bob that hangs in Cartesian coordinates: u_x, which `derive` would have follow, moves freely there."""
    rod = HEAD + (
        "    return kn.System(N, bodies=[kn.Particle('bob', P, m)], speeds='rates', holonomic=kn.distance(P, O, 1.0),\n"
        "                     loads=[kn.gravity(-9.81 * N.y)])\n\n"
    )
    path = tmp_path / "bob.py"
    for q, u in (((0.0, -1.0), (0.5, 0.0)), ((1.0, 0.0), (0.0, 0.5))):
        begin = {"q": dict(zip("xy", q, strict=True)), "u": dict(zip(("u_x", "u_y"), u, strict=True))}
        path.write_text(f"{rod}START = {begin}\n", encoding="utf-8")
        assert "No error found" in kane("check", path).output
        assert kane("simulate", path, "--t1", 0.1).exit_code == 0


def test_derive_prints_the_steps(top):
    said = kane("derive", "spinning_top").stdout
    assert re.findall(r"^Step (\d)\.", said, re.MULTILINE) == list("1234567")
    alone = kane("derive", "spinning_top", "--step", 3).stdout
    assert alone.startswith("Step 3. Generalized speeds")
    assert re.search(r"^ +u_psi += psi'$", alone, re.MULTILINE)
    assert alone.strip() in said


def test_derive_in_latex_and_json():
    force = kn.derive(load("pendulum").system()).Fr[0]
    said = kane("derive", "pendulum", "--latex", "--step", 5).stdout.splitlines()
    assert said[:2] == ["% Step 5. Generalized active forces", "\\begin{align*}"]
    assert said[2:] == [rf"  F_{{u_{{\theta}}}} &= {kn.to_latex(force)}", "\\end{align*}"]
    whole = kane("derive", "pendulum", "--latex").stdout
    assert whole.count("\\begin{align*}") == whole.count("\\end{align*}") == 6
    steps = from_json("derive", "pendulum")["steps"]
    assert [s["number"] for s in steps] == [1, 2, 3, 4, 5, 6, 7]
    assert steps[4]["formulas"] == [
        {
            "name": "F_u_theta",
            "text": kn.to_text(force),
            "latex": rf"F_{{u_{{\theta}}}} = {kn.to_latex(force)}",
        }
    ]
    assert "step" in line(kane("derive", "pendulum", "--step", 8, code=2).stderr)


def test_simulate_gives_the_library_s_motion(tmp_path):
    words = ("simulate", "pendulum", "--t1", 2, "--q", "theta=0.3", "--u", "u_theta=-1", "--parameter", "c=0")
    found = from_json(*words, "--csv", "out/run.csv")
    sol = kn.simulate(
        kn.derive(load("pendulum").system()), (0, 2), q={"theta": 0.3}, u={"u_theta": -1}, parameters={"c": 0}
    )
    assert found["values"]["theta"]["end"] == sol["theta"][-1]
    assert found["values"]["theta"]["least"] == sol["theta"].min()
    assert found["parameters"]["c"] == 0
    assert (found["ok"], found["status"], found["t1"], found["steps"]) == (True, "finished", 2.0, sol.steps)
    assert found["energy"]["relative"] == sol.energy_check.relative
    with (tmp_path / "out" / "run.csv").open(encoding="utf-8") as file:
        head, *rows = list(csv.reader(file))
    assert head == ["t", "theta", "u_theta", "E"]
    values = np.array(rows, dtype=float)
    assert np.array_equal(values, np.column_stack([sol.t, sol.states, sol.energy]))
    assert np.ptp(values[:, 3]) < 1e-7  # without friction the energy stays
    said = kane(*words).stdout
    assert "reached t = 2." in said
    assert re.search(rf"^theta +0\.3 +{sol['theta'][-1]:.6g} ", said, re.MULTILINE)
    assert "pass  energy less the work of the loads" in said


@pytest.mark.slow
def test_simulate_draws_the_motion(tmp_path):
    told = kane("simulate", "pendulum", "--t1", 1, "--plot", "out/run.svg").stderr
    assert "Written: out/run.svg" in told
    text = (tmp_path / "out" / "run.svg").read_text(encoding="utf-8")
    svg = ElementTree.fromstring(text)
    assert svg.tag.endswith("svg")
    assert all(f"<!-- {label} -->" in text for label in ("t [s]", r"$\theta$ [rad]", "energy [J]"))
    kane("simulate", "pendulum", "--t1", 1, "--plot", "run.png")
    assert (tmp_path / "run.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.slow
@pytest.mark.parametrize(
    "words",
    [("report", "--out"), ("simulate", "--csv"), ("simulate", "--plot"), ("emit", "--target", "c", "--out"), ("new",)],
)
def test_nothing_is_written_over(words, tmp_path):
    model = [] if words[0] == "new" else ["pendulum"]
    place = tmp_path / (
        "x.html" if words[0] == "report" else {"--csv": "x.csv", "--plot": "x.svg"}.get(words[-1], "x.py")
    )
    place.write_text("mine")
    told = kane(words[0], *model, *words[1:], place, code=2)
    assert "Expected a new file, got" in line(told.stderr)
    assert "which already exists. Choose another name, or add --force." in line(told.stderr)
    assert place.read_text() == "mine"
    kane(words[0], *model, *words[1:], place, "--force")
    assert place.read_bytes() != b"mine"


def test_simulate_from_the_file_s_start(tmp_path):
    text = (
        SPRING + "START = {'q': {'x': 1, 'y': 0}, 'u': {'u_x': 0, 'u_y': 0}, 'parameters': {'k': 8}}\nSPAN = (1, 3)\n"
    )
    found = from_json("simulate", written(tmp_path, text))
    assert (found["t0"], found["t1"]) == (1.0, 3.0)
    assert found["values"]["x"]["end"] == pytest.approx(np.cos(2 * 2.0), abs=1e-7)  # omega = sqrt(8 / 2) over 2 s


def test_simulate_with_an_input(tmp_path):
    text = (
        "from kane.gallery import pendulum_on_cart\n\ndef system():\n    return pendulum_on_cart.system(force=True)\n"
    )
    text += "START = {'q': {'x': 0, 'theta': 0}, 'u': {'u_x': 0, 'u_theta': 0}}\n"
    file = written(tmp_path, text)
    assert "--input F=…" in line(kane("simulate", file, code=2).stderr)
    assert from_json("simulate", file, "--input", "F=2", "--t1", 1)["values"]["x"]["end"] > 0.1
    failing = written(tmp_path, text[:-2] + ", 'inputs': {'F': lambda t: {}[t]}}\n", "failing.py")
    told = kane("simulate", failing, code=1).stderr
    assert "function of time for the input F, got KeyError from it at t = 0: 0.0" in line(told)
    assert told.splitlines()[-1].startswith("in failing.py, line 5: START")


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--q", "thta=1"), "a coordinate (theta) in --q, got 'thta'. Did you mean theta?"),
        (("--q", "theta"), "Expected --q NAME=VALUE with a finite number, got 'theta'"),
        (("--q", "theta=inf"), "Expected --q NAME=VALUE with a finite number, got 'theta=inf'"),
        (("--q", "theta=1", "--q", "theta=2"), "Expected one value for each name, got --q theta=… twice"),
        (("--input", "F=1"), "the name of an input (the model has none) in --input, got 'F'"),
        (("--t1", "-1"), "to end after its start at 0 s, got --t1 -1"),
        (("--csv", "."), "Expected a file to write, got the folder ."),
        (("--plot", "."), "Expected --plot FILE that ends in .png, .svg, .pdf, got ."),
        (("--plot", "a.jpg"), "Expected --plot FILE that ends in .png, .svg, .pdf, got a.jpg"),
    ],
)
def test_wrong_options(words, message):
    assert message in line(kane("simulate", "pendulum", *words, code=2).stderr)


def test_simulation_that_breaks_off_is_the_exit_code(tmp_path):
    text = SPRING.replace("kn.linear_spring(P, O, k)", 'kn.Force(P, k * x**3 / kn.parameter("a", 1, "m") ** 2 * N.x)')
    text += "START = {'q': {'x': 1, 'y': 0}, 'u': {'u_x': 1, 'u_y': 0}, 'parameters': {'k': 9}}\n"  # x escapes
    found = from_json("simulate", written(tmp_path, text), code=1)
    assert (found["ok"], found["status"]) == (False, "stopped")
    assert found["t1"] < 5


def test_no_result_is_written_over_the_model(tmp_path):
    file = written(tmp_path, SPRING)
    assert "other than the model's own" in line(kane("emit", file, "--target", "c", "--out", file, code=2).stderr)
    assert file.read_text(encoding="utf-8") == SPRING


LONG = (
    "bricard",
    "rattleback",
    "car_with_trailer",
    "whipple_bicycle",
    "skidding_bicycle",
    "pure_rolling_disk",
    "andrews_squeezer",
    "flexible_satellite",
    "tippe_top",
    "pool_ball",
    "slider_crank_with_clearance",
    "stacked_blocks",
    "flexible_arm",
    "flap_lag_blade",
    "thrown_disk",
)


@pytest.mark.parametrize("name", [pytest.param(n, marks=pytest.mark.slow) if n in LONG else n for n in GALLERY])
def test_every_system_of_the_gallery_has_a_start(name):
    module = load(name)
    system, start = module.system(), getattr(module, "START", STARTS.get(name))
    assert start is not None
    assert set(start["q"]) == {q.name for q in system.coordinates}
    assert set(start["u"]) <= {u.name for u in system.speeds}
    assert from_json("simulate", name, "--t1", 0.01)["energy"]["passed"]


@pytest.mark.parametrize("name", [pytest.param(n, marks=pytest.mark.slow) if n in LONG else n for n in GALLERY])
def test_check_warns_of_nothing_in_the_gallery(name):
    assert set(from_json("check", name)["warnings"]) <= {"No loads: only inertia forces act."}


def test_emit(tmp_path):
    compiled = kn.derive(load("pendulum").system()).compile(name="swing")
    for target in targets.EMITTERS:
        assert kane("emit", "pendulum", "--target", target, "--name", "swing").stdout == compiled.emit(target)
    said = kane("emit", "pendulum", "--target", "numpy", "--out", "made/swing.py")
    assert said.stdout == ""
    module = runpy.run_path(str(tmp_path / "made" / "swing.py"))
    p = [q.default for q in compiled.equations.parameters]
    x = [0.4, 0.2]
    made = module["rhs"](0.0, np.array(x), np.array(p))
    assert np.allclose(made, compiled.rhs(0.0, np.array(x)), rtol=1e-14, atol=0)
    assert "identifier" in line(kane("emit", "pendulum", "--target", "c", "--name", "a b", code=2).stderr)
    assert "fortran" in line(kane("emit", "pendulum", "--target", "fortran", code=2).stderr)


def test_bench_measures_and_counts():
    found = from_json("bench", "pendulum")
    assert found["operations"]["rhs"]["total"] == kn.derive(load("pendulum").system()).compile().operations["rhs"].total
    seconds = found["seconds"]
    assert all(0 < s < 10 for s in seconds.values())
    assert all(a > b for a, b in pairwise((seconds["compile"], seconds["call"], seconds["state"])))
    said = kane("bench", "pendulum").stdout
    assert re.search(r"^compile +[\d.]+ ms", said, re.MULTILINE)
    assert re.search(r"^  rhs +\d+ operations: ", said, re.MULTILINE)


@pytest.mark.slow
def test_new_model_goes_through_every_command(tmp_path):
    told = kane("new", "x.py").stderr
    assert "Written: x.py" in told
    assert "SPDX" not in (tmp_path / "x.py").read_text(encoding="utf-8")
    found = from_json("check", "x.py")
    assert [b["name"] for b in found["bodies"]] == ["cart", "upper rod", "lower rod"]
    assert found["warnings"] == []
    assert "Step 7." in kane("derive", "x.py").stdout
    assert from_json("simulate", "x.py", "--t1", 2)["energy"]["relative"] < 1e-7
    assert "x_rhs(" in kane("emit", "x.py", "--target", "c").stdout
    assert "rhs" in from_json("bench", "x.py")["operations"]
    assert "Report: x.html" in kane("report", "x.py", "--t1", 2).stdout


def test_new_does_not_write_over_a_file(tmp_path):
    file = written(tmp_path, "mine\n")
    assert "add --force" in line(kane("new", file, code=2).stderr)
    assert file.read_text(encoding="utf-8") == "mine\n"
    kane("new", file, "--force")
    assert "def system()" in file.read_text(encoding="utf-8")
    assert "model.py" in line(kane("new", "model.txt", code=2).stderr)


def test_report_on_the_equilibrium_under_inputs_that_are_functions(tmp_path):
    """They have the values of the start, as everywhere: before, an error told to call them."""
    text = HEAD + (
        "    f = kn.input('f', 'N')\n"
        "    c = kn.parameter('c', 1.0, 'N*s/m')\n"
        "    loads = [kn.linear_spring(P, O, k), kn.Force(P, f * N.x), kn.Force(P, -c * P.velocity(N))]\n"
        "    return kn.System(N, bodies=[kn.Particle('bob', P, m)], speeds='rates', loads=loads)\n\n"
        "START = {'q': {'x': 1, 'y': 0}, 'u': {'u_x': 0, 'u_y': 0}, 'parameters': {'k': 2}, 'inputs': {'f': lambda t: 3 + t}}\n"
    )
    file = written(tmp_path, text)
    kane("report", file, "--out", tmp_path / "a.md", "--linearization", "--t1", 0.1)
    assert "1.5" in (tmp_path / "a.md").read_text(encoding="utf-8")


@pytest.mark.slow
def test_report_on_the_steady_motion(tmp_path):
    """Linearized, and its eigenvalues along a parameter; a range that is none is refused."""
    kane("report", "pendulum", "--out", "a.html", "--t1", 1, "--linearization", "--root-locus", "g=5:20")
    page = (tmp_path / "a.html").read_text(encoding="utf-8")
    kane("report", "pendulum", "--out", "b.html", "--t1", 1)
    plain = Page((tmp_path / "b.html").read_text(encoding="utf-8"))
    more = set(Page(page).sections) - set(plain.sections)
    assert len(more) >= 3
    assert any("locus" in name or "loci" in name for name in more)
    said = kane("report", "pendulum", "--out", "c.html", "--t1", 1, "--root-locus", "g", code=2).stderr
    assert "NAME=LOW:HIGH" in said


@pytest.mark.slow
def test_report_with_and_without_a_motion(tmp_path):
    said = kane("report", "pendulum", "--out", "a/b.html", "--t1", 1)
    assert "reached t = 1." in said.stdout
    page = Page((tmp_path / "a" / "b.html").read_text(encoding="utf-8"))
    assert page.loads == []
    assert {"motion", "checks", "sources"} <= set(page.sections)
    file = written(tmp_path, SPRING)
    assert "The report has no motion: START does not give" in kane("report", file).stderr
    page = Page((tmp_path / "model.html").read_text(encoding="utf-8"))
    assert "motion" not in page.sections
    before = (tmp_path / "model.html").read_bytes()
    assert "Choose another name, or add --force" in line(kane("report", file, code=2).stderr)
    assert (tmp_path / "model.html").read_bytes() == before
    assert "--q x=…" in line(kane("report", file, "--t1", 3, "--force", code=2).stderr)
    assert "Report: b.tex" in kane("report", file, "-o", "b.tex").stdout
    assert {"b.tex", "b-sketch.pdf"} == {p.name for p in tmp_path.glob("b*.*")}
    assert "Report: model.md" in kane("report", file, "--format", "markdown").stdout
    assert (tmp_path / "model-sketch.svg").is_file()
    (tmp_path / "b.tex").unlink()
    assert "b-sketch.pdf, which already exists" in line(kane("report", file, "-o", "b.tex", code=2).stderr)
    assert not (tmp_path / "b.tex").exists()
    assert "ends in .html" in line(kane("report", file, "-o", "b.docx", code=2).stderr)


def test_emit_writes_webassembly(tmp_path):
    kane("emit", "pendulum", "--target", "wasm", "--with-integrator", "tsit5", "--out", "made/swing.wasm")
    compiled = kn.derive(load("pendulum").system()).compile(name="pendulum")
    assert Path("made/swing.wasm").read_bytes() == emit_simulator_wasm(compiled, "tsit5")
    kane("emit", "pendulum", "--target", "wasm", "--out", "made/pendulum.wasm")
    assert Path("made/pendulum.wasm").read_bytes() == compiled.emit("wasm")


def test_emit_writes_a_functional_mock_up_unit(tmp_path):
    file = tmp_path / "swing.fmu"
    kane("emit", "pendulum", "--target", "fmu", "--name", "swing", "--with-integrator", "tsit5", "--out", file)
    with zipfile.ZipFile(file) as archive:
        assert {"modelDescription.xml", "sources/swing.c", "sources/buildDescription.xml"} <= set(archive.namelist())
        told = archive.read("modelDescription.xml").decode()
    assert 'name="theta" valueReference="1" causality="output" variability="continuous"' in told
    assert "Expected --out FILE.fmu" in line(kane("emit", "pendulum", "--target", "fmu", code=2).stderr)
    said = line(kane("emit", "skidding_bicycle", "--target", "fmu", "--out", tmp_path / "bicycle.fmu", code=1).stderr)
    assert "64 modes of contacts, too many to include all" in said


def test_emit_prints_a_program_that_simulates():
    found = kane("emit", "double_pendulum", "--target", "c", "--with-integrator", "tsit5").stdout
    assert "int main(" in found
    assert "static int64_t tsit5(" in found
    assert (
        "Expected --target c, wasm or fmu with --with-integrator"
        in kane("emit", "double_pendulum", "--target", "h", "--with-integrator", "rk4", code=2).stderr
    )
    assert (
        "Expected an integrator among"
        in kane("emit", "double_pendulum", "--target", "c", "--with-integrator", "euler", code=1).stderr
    )


NARROW = (
    "gallery", "check rolling_disk", "derive pendulum", "simulate pendulum", "bench pendulum", "cache info", "--help",
    "simulate --help", "simulat", "simulate", "simulate pendulum --t1 soon",
    "check pendulun", "simulate pendulum --q psi=1", "--bogus", "check four_bar",
    "simulate four_bar",
)  # fmt: skip
MISUSED = (
    "simulat", "--bogus", "simulate", "simulate pendulum --bogus", "derive pendulum --step 9", "simulate pendulum --t1 soon",
    "check a b", "check pendulun", "cache empty",
)  # fmt: skip


@pytest.mark.parametrize("width", [60, 100])
def test_a_narrow_terminal_breaks_no_word(width, monkeypatch):
    """Each line fits, or is one word."""
    monkeypatch.setenv("COLUMNS", str(width))
    for words in NARROW:
        for text in CliRunner().invoke(app, words.split()).output.splitlines():
            assert len(text) <= width or " " not in text.strip(), (words, text)


def test_usage_errors_read_as_those_of_models():
    """One style: "error: Expected …, got …" on the other stream, and 2 where the arguments are wrong."""
    for words in MISUSED:
        result = kane(*words.split(), code=2)
        assert re.match(r"error: Expected .*, got ", line(result.stderr)), result.stderr
        assert result.stdout == ""


def test_speeds_left_out_of_start_are_asked_for(tmp_path):
    """The coordinates that START gives are assembled without them, and what is missing is each independent speed."""
    file = written(
        tmp_path,
        "import kane as kn\nfrom kane.gallery.four_bar import system\nSTART = {'q': {'q1': 1.2, 'q2': kn.guess(-1)}}\n",
    )
    said = [line(w) for w in from_json("check", file)["warnings"]]
    assert said == ["START is incomplete: a simulation needs --u u2=…."]
    assert "add --u u2=…, or set them in START" in line(kane("simulate", file, code=2).stderr)


def test_sketch_draws_the_model(tmp_path):
    assert kane("sketch", "spinning_top", "-o", "top.svg").stdout == "Sketch: top.svg\n"
    text = (tmp_path / "top.svg").read_text("utf-8")
    assert 'class="kane-sketch" width="640"' in text
    assert all(f'data-s="{q}"' in text for q in ("psi", "theta", "phi"))
    assert "Expected a new file" in line(kane("sketch", "spinning_top", "-o", "top.svg", code=2).stderr)
    assert kane("sketch", "spinning_top", "-o", "top.svg", "--width", 330, "--force").stdout
    assert 'width="330"' in (tmp_path / "top.svg").read_text("utf-8")
    assert "ends in" in line(kane("sketch", "spinning_top", "-o", "top.gif", code=2).stderr)


def test_models_of_other_tools_and_units_without_a_start_say_what_to_do(tmp_path):
    (tmp_path / "arm.urdf").write_text("<robot/>", "utf-8")
    assert "`kane convert arm.urdf -o model.py`" in line(kane("sketch", "arm.urdf", code=2).stderr)
    written(tmp_path, SPRING, "arm.py")
    said = line(kane("emit", "arm.py", "--target", "fmu", "--out", "arm.fmu", code=2).stderr)
    assert "got none for k" in said
    assert said.endswith("See START of the model's file.")
    written(
        tmp_path, SPRING + "START = dict(q={'x': 1, 'y': 0}, u={'u_x': 0, 'u_y': 0}, parameters={'k': 2})\n", "arm.py"
    )
    kane("emit", "arm.py", "--target", "fmu", "--out", "arm.fmu")
    assert "sources/model_arm.c" in zipfile.ZipFile("arm.fmu").namelist()

# SPDX-License-Identifier: BSD-3-Clause
"""MODEL: gallery, files, and what can be wrong with a file; no error shows a line of kane."""

from __future__ import annotations

import pytest

from kane.cli import LINES, names_like
from kane.gallery import GALLERY, load
from tests.cli.command import HEAD, SPRING, from_json, kane, line, written


@pytest.fixture(autouse=True)
def _here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


def test_gallery_is_listed_with_titles():
    lines = kane("gallery").stdout.splitlines()
    assert [row.split("  ")[0] for row in lines] == list(GALLERY)
    assert "heavy symmetrical top" in lines[list(GALLERY).index("spinning_top")]
    assert from_json("gallery") == [{"name": n, "title": load(n).TITLE} for n in GALLERY]


def test_misspelt_name_is_answered_with_suggestions_and_where_the_list_is():
    told = line(kane("check", "spining_top", code=2).stderr)
    assert "Did you mean spinning_top" in told
    assert "`kane gallery` lists the systems" in told


def test_absent_file(tmp_path):
    written(tmp_path, SPRING, "crane.py")
    told = line(kane("check", "crain.py", code=2).stderr)
    assert "crain.py, which does not exist. Did you mean crane.py?" in told
    assert "got 'crane'. Did you mean crane.py?" in line(kane("check", "crane", code=2).stderr)
    assert "got the folder" in line(kane("check", str(tmp_path), code=2).stderr)


def test_misspelt_command():
    assert "simulate" in kane("simulat", "pendulum", code=2).stderr


def test_users_error_is_shown_through_the_users_frames_alone(tmp_path):
    written(tmp_path, "def inverse(x):\n    return 1 / x\n", "own_helper_7.py")
    file = written(tmp_path, "import own_helper_7\n\ndef system():\n    return own_helper_7.inverse(0)\n")
    told = kane("check", file, code=1).stderr
    files = [row.split('"')[1] for row in told.splitlines() if row.startswith("  File")]
    assert files == [str(file), str(tmp_path / "own_helper_7.py")]
    assert f'"{file}", line 4, in system' in told
    assert told.splitlines()[-1] == "ZeroDivisionError: division by zero"


def test_users_error_inside_a_library_ends_at_the_users_line(tmp_path):
    file = written(tmp_path, "import numpy as np\n\ndef system():\n    return np.linalg.inv(np.zeros((2, 2)))\n")
    told = kane("check", file, code=1).stderr
    assert told.count("  File") == 1
    assert "line 4, in system" in told
    assert "LinAlgError: Singular matrix" in told


def test_chained_errors_keep_what_is_the_users(tmp_path):
    text = (
        "def system():\n    try:\n        {}['a']\n    except KeyError as e:\n        raise ValueError('no a') from e\n"
    )
    told = kane("check", written(tmp_path, text), code=1).stderr
    assert told.index("KeyError: 'a'") < told.index("direct cause") < told.index("ValueError: no a")
    assert "kane/cli" not in told


def test_syntax_error_names_file_and_line(tmp_path):
    file = written(tmp_path, "\n\ndef system(:\n    pass\n")
    told = kane("derive", file, code=1).stderr
    assert f'File "{file}", line 3' in told
    assert "SyntaxError" in told
    assert "Traceback" not in told


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            "def sistem():\n    pass\n",
            "Expected a function system() in model.py, got only sistem(). Rename sistem to system, or define one that",
        ),
        ("x = 1\n", "Expected a function system() in model.py, got no function."),
        ("system = 3\n", "Expected system in model.py to be a function, got int (3)"),
        ("def system():\n    pass\n", "to return a kn.System, got None: end it with `return kn.System(…)`"),
        ("def system():\n    return 'pendulum'\n", "to return a kn.System, got str ('pendulum')"),
        ("def system(n):\n    pass\n", "to need no arguments, got one with missing a required argument: 'n'"),
        ("import sys\nsys.exit(4)\n", "to declare a model and run to its end, got a call of sys.exit()"),
        (
            SPRING + "START = {'q0': {}}\n",
            "START in model.py to have keys among q, u, parameters, inputs, states, got 'q0'",
        ),
        (SPRING + "START = {'q': {'X': 1}}\n", "a coordinate (x, y) in START['q'], got 'X'"),
        (SPRING + "SPAN = 5\n", "SPAN in model.py to be two times (t0, t1) in s, got 5"),
    ],
)
def test_wrong_files_are_named(tmp_path, text, message):
    told = kane("check", written(tmp_path, text), code=1).stderr
    assert message in line(told)
    assert told.startswith("error: Expected")
    assert "Traceback" not in told


def test_error_of_kane_names_the_users_line(tmp_path):
    file = written(tmp_path, HEAD + "    return kn.System(N, bodies=[], speeds='rates')\n")
    told = kane("check", file, code=1).stderr
    assert told.startswith("error: Expected")
    assert "Traceback" not in told
    assert told.splitlines()[-1] == "in model.py, line 10: return kn.System(N, bodies=[], speeds='rates')"


def test_an_option_s_mistake_is_not_placed_in_the_file(tmp_path):
    file = written(tmp_path, SPRING + "START = {'q': {'x': 1}}\n")
    told = line(kane("simulate", file, "--parameter", "kk=2", code=2).stderr)
    assert "got 'kk'. Did you mean k?" in told
    assert "model.py" not in told


def test_long_message_is_cut_but_keeps_its_place(tmp_path):
    text = "import kane as kn\n\ndef system():\n    raise kn.ModelError('\\n'.join(f'row {i}' for i in range(60)))\n"
    lines = kane("check", written(tmp_path, text), code=1).stderr.splitlines()
    assert len(lines) == LINES == 15
    assert lines[0] == "error: row 0"
    assert lines[-2] == "  … (47 more lines)"
    assert lines[-1].startswith("in model.py, line 4: raise kn.ModelError(")


def test_error_found_in_the_derivation(tmp_path):
    text = HEAD + "    u = kn.speed('u')\n    return kn.System(N, bodies=[kn.Particle('p', P, m)], speeds={u: x.dt})\n"
    file = written(tmp_path, text)
    assert "got none with y'" in line(kane("check", file, code=1).stderr)
    found = from_json("check", file, code=1)
    assert (found["ok"], found["error"]["type"]) == (False, "SpeedsError")
    assert "got none with y'" in line(found["error"]["message"])


def test_python_error_as_json(tmp_path):
    found = from_json("check", written(tmp_path, "1 / 0\n"), code=1)["error"]
    assert found["type"] == "UserError"
    assert found["message"].splitlines()[-1] == "ZeroDivisionError: division by zero"


def test_warnings_of_the_model_are_reported(tmp_path):
    text = SPRING.replace("import kane as kn\n", "import warnings\nimport kane as kn\n", 1)
    text = text.replace("    N = ", "    warnings.warn('Odd.', kn.KaneWarning)\n    N = ")
    file = written(tmp_path, text)
    assert from_json("check", file)["warnings"][0] == "Odd."
    assert "\n  Odd.\n" in kane("check", file).stdout
    assert "warning: Odd.\n" in kane("derive", file).stderr


def test_file_that_is_not_python(tmp_path):
    (tmp_path / "photo.py").write_bytes(b"\x89PNG\x00\x01")
    told = kane("check", "photo.py", code=1).stderr
    assert "SyntaxError" in told
    assert "kane/cli" not in told


def test_what_a_file_prints_does_not_mix_with_json(tmp_path):
    file = written(tmp_path, "print('hello')\n" + SPRING)
    assert from_json("check", file)["bodies"][0]["name"] == "bob"
    assert "hello" in kane("check", file).stderr


def test_file_is_read_anew_and_leaves_nothing_beside_it(tmp_path):
    file = written(tmp_path, SPRING)
    before = from_json("check", file)["parameters"]
    written(tmp_path, SPRING.replace("2.0", "3.0"))
    after = from_json("check", file)["parameters"]
    assert [p["default"] for p in (*before, *after) if p["name"] == "m"] == [2.0, 3.0]
    assert [p.name for p in tmp_path.iterdir()] == ["model.py"]


def test_completion_offers_the_gallery_and_python_files(tmp_path):
    written(tmp_path, SPRING, "spin.py")
    (tmp_path / "spare").mkdir()
    assert names_like("sp") == ["spherical_pendulum", "spinning_top", "sphere_on_turntable", "spare/", "spin.py"]
    assert names_like("pendulums") == ["pendulums"]

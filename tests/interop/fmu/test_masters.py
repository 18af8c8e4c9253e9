# SPDX-License-Identifier: BSD-3-Clause
"""Units in masters other than fmpy: one in C under the sanitizers, without Python, and DNV's libcosim by its FMI Library."""

import subprocess
import zipfile
from pathlib import Path

import numpy as np
import pytest

import kane as kn
from tests.interop.fmu.units import STRICT, TIGHT, far, model, reference, written
from tests.peer import require
from tests.program.programs import compiler

SANITIZED = ("-O0", "-fsanitize=address,undefined", "-fno-sanitize-recover=all")


@pytest.mark.slow
@pytest.mark.parametrize("name", ["ball", "four_bar"])
def test_a_master_in_c_under_the_sanitizers(tmp_path, name):
    eom, given = model(name)
    unit = kn.exchange.to_fmu(eom, tmp_path / f"{name}.fmu", binary=False, tolerance=TIGHT, method="tsit5", **given)
    with zipfile.ZipFile(unit.path) as archive:
        archive.extractall(tmp_path)
    source = tmp_path / "sources" / f"{name}.c"
    own = [
        *STRICT,
        *SANITIZED,
        f'-DUNIT="{source}"',
        Path(__file__).with_name("master.c"),
        "-o",
        tmp_path / "master",
        "-lm",
    ]
    done = subprocess.run(
        [compiler(), *own], capture_output=True, text=True, check=False, env={"PATH": "/usr/bin:/bin"}
    )
    assert done.returncode == 0, done.stderr
    ran = subprocess.run([tmp_path / "master"], capture_output=True, text=True, check=False, env={})
    assert ran.returncode == 0, ran.stderr
    found = np.array([float(x) for x in ran.stdout.split()])
    assert far(found, reference(eom, 0.5, 2, given).states[-1]) < 1e-8


@pytest.mark.parametrize("name", ["ball", pytest.param("slider_crank", marks=pytest.mark.slow)])
def test_libcosim_steps_a_unit(tmp_path, name):
    require("libcosimpy")
    execution, slave, observer = (
        getattr(require(f"libcosimpy.Cosim{part}"), f"Cosim{of}")
        for part, of in (("Execution", "Execution"), ("Slave", "LocalSlave"), ("Observer", "Observer"))
    )
    eom, given = model(name)
    unit = written(tmp_path, name, eom, given, version="2.0")
    run = execution.from_step_size(100_000_000)  # ns
    index = run.add_local_slave(slave(str(unit.path), name))
    last = observer.create_last_value()
    run.add_observer(last)
    for _ in range(10):
        assert run.step()
    found = last.last_real_values(index, list(range(1, len(eom.state) + 1)))
    assert far(np.array(found), reference(eom, 1.0, 2, given).states[-1]) < 1e-8

# SPDX-License-Identifier: BSD-3-Clause
"""How many files of the source a model visits from its declaration to `sol[q]`: those with functions that are called on the way.

`python requirements/visits.py` prints a row a model, each from a process of its own without a cache of machine code, and fails where
there are more than `MOST`. The row of the event counts the files of `motion` with functions that are called because of it: those that
the same motion without the event does not call.
"""

import inspect
import json
import os
import subprocess
import sys
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from types import CodeType, FrameType

SOURCE = Path(__file__).parents[1] / "src" / "kane"
FEW = 8
"""Packages that are named in a row."""
MOST = {"pendulum": 100, "four_bar": 120, "event": 5}
"""Files at most: these figures follow what is reached. Of the event three are where the kernel is written that looks for events."""
Visited = set[tuple[str, str]]
"""Files, relative to the source, and the qualified names of their functions."""


def pendulum(event: bool = False) -> None:
    """A particle on a massless rod; with an event, whose action turns its speed where it passes a stop."""
    import kane as kn

    frame, q, u = kn.Frame("N"), kn.coordinate("q"), kn.speed("u")
    pivot = kn.Point("O", fixed_in=frame)
    m, length, g = kn.parameter("m", 1.0, "kg"), kn.parameter("l", 0.5, "m"), kn.parameter("g", 9.81, "m/s^2")
    rod = frame.rotate("B", q, frame.z)
    bob = kn.Particle("bob", pivot.at("P", length * rod.x), m)
    system = kn.System(
        frame,
        bodies=[bob],
        speeds={u: q.dt},
        loads=[kn.gravity(g * frame.x)],
        events=[kn.Event("stop", q, direction=-1, then={u: -0.8 * u})] if event else [],
    )
    sol = kn.simulate(kn.derive(system), (0, 1), q={q: 0.4}, u={u: 0.0})
    assert sol[q].shape == sol.t.shape


def bouncing() -> None:
    """The pendulum with its event."""
    pendulum(event=True)


def four_bar() -> None:
    """The four-bar linkage of the gallery."""
    import kane as kn
    from kane.gallery import four_bar as linkage

    eom = kn.derive(linkage.system())
    sol = kn.simulate(eom, (0, 1), **linkage.START)
    assert sol[eom.coordinates[0]].shape == sol.t.shape


MODELS: dict[str, Callable[[], None]] = {f.__name__: f for f in (pendulum, bouncing, four_bar)}


def visited(model: Callable[[], None]) -> Visited:
    """The functions of the source that are called while a model runs; bodies of modules and classes are none."""
    codes: set[CodeType] = set()

    def note(frame: FrameType, event: str, _: object) -> None:
        if event == "call":
            codes.add(frame.f_code)

    sys.setprofile(note)
    try:
        model()
    finally:
        sys.setprofile(None)
    prefix = f"{SOURCE}{os.sep}"
    return {
        (code.co_filename.removeprefix(prefix), code.co_qualname)
        for code in codes
        if code.co_filename.startswith(prefix) and code.co_flags & inspect.CO_OPTIMIZED
    }


def traced(name: str) -> Visited:
    """The same in a process of its own."""
    done = subprocess.run(
        [sys.executable, __file__, name],
        env={**os.environ, "KANE_CACHE": "off", "PYTHONPATH": str(SOURCE.parent), "PYTHONHASHSEED": "0"},
        capture_output=True,
        text=True,
        check=True,
    )
    return {(file, function) for file, function in json.loads(done.stdout)}


def counted() -> dict[str, Visited]:
    """The functions that each row counts."""
    calls = {name: traced(name) for name in MODELS}
    event = {(file, name) for file, name in calls["bouncing"] - calls["pendulum"] if file.startswith("motion/")}
    return {"pendulum": calls["pendulum"], "four_bar": calls["four_bar"], "event": event}


def row(name: str, calls: Visited) -> str:
    """What is printed of functions that were called."""
    files = {file for file, _ in calls}
    packages = Counter(Path(file).parts[0].removesuffix(".py") for file in files)
    named = ", ".join(f"{package} {count}" for package, count in packages.most_common(FEW))
    return f"{name:12} {len(files):4} files of at most {MOST[name]}, {len(calls)} functions: {named}"


def main() -> int:
    """Print the rows; of a model by name its calls, as JSON; 1 where there are more files than `MOST`."""
    if len(sys.argv) > 1:
        print(json.dumps(sorted(visited(MODELS[sys.argv[1]]))))
        return 0
    calls = counted()
    print("\n".join(row(name, those) for name, those in calls.items()))
    print("  " + "\n  ".join(sorted({file for file, _ in calls["event"]})))
    return int(any(len({file for file, _ in those}) > MOST[name] for name, those in calls.items()))


if __name__ == "__main__":
    sys.exit(main())

# SPDX-License-Identifier: BSD-3-Clause
"""Modules of WebAssembly give the motions of `simulate` bit by bit, where no a·b + c is contracted, at any position of the sliders."""

import base64
import os
import warnings
from importlib.resources import files

import numpy as np
import pytest

import kane as kn
from kane.gallery import GALLERY, load
from kane.motion import emit_simulator_wasm
from tests.motion.emitted import EXACT, ball, bits
from tests.motion.hosted import Engine
from tests.peer import require
from tests.present.browser import chromium

require("wasmtime")
POSITIONS = 100 if os.environ.get("KANE_FULL") else 2
QUICK = ("double_pendulum", "four_bar")
CONTACTS = {name for name in GALLERY if load(name).system().contacts}
ASKS = {
    "car_with_trailer": "an input prescribes a motion",
    "snakeboard": "its start is singular",
    "n_four_bar": "constraints may be singular: Python looks at steps",
}
"""Those of the gallery that ask Python from the beginning on, beside contacts that change their modes."""
ALONE = {"free_body": {"q": [1, 0, 0, 0, 0.1, 0.2, 0.3], "u": [0.1, 2.0, 0.2, 0, 0, 0]}}
BEAMS = {name for name in GALLERY if name.startswith("flexible") or name == "flap_lag_blade"}
AS_GIVEN = {"whipple_bicycle", "flexible_slider_crank", "flexible_four_bar"}
"""Those of which starts are the gallery's: beside them elastic speeds, or the wheels' forces, are beyond all reason."""
MOST = {"whipple_bicycle": 0.1, "andrews_squeezer": 0.01}
"""Ends of motions (s) that are shorter than others."""


def engine(eom, method, samples=200):
    """The motion's module, running."""
    return Engine(emit_simulator_wasm(eom.compile(name="model", contract=False), method, samples))


def positions(name, eom, count, rng):
    """Starts and parameters near those of the gallery, on the constraints."""
    start = ALONE.get(name) or getattr(load(name), "START", None)
    defaults = {s: float(s.default) for s in eom.parameters if s.default}
    free = not (eom.system.holonomic or eom.b or eom.system.euler_parameters)
    if start is None:
        small = 1e-3 if name in BEAMS else 0.1
        start = {"q": small * np.arange(1, len(eom.coordinates) + 1), "u": np.full(len(eom.speeds), small)}
    base = kn.assemble(eom, **start)
    share = 0.0 if name in BEAMS else 0.5
    as_given = kn.guess if not free else float
    found = 0
    for width in (0.1 * 0.7**k for k in range(20) for _ in range(count)):
        change = rng.uniform(1 - width, 1 + width, 400)
        parameters = {s: v * x for (s, v), x in zip(defaults.items(), change, strict=False)}
        q, u = (
            {s: as_given(v * x + share * (x - 1)) for (s, v), x in zip(known.items(), change[k:], strict=False)}
            for k, known in ((100, base.q), (200, base.u))
        )
        near = start if name in AS_GIVEN else {"q": q, "u": u}
        try:
            state = kn.assemble(eom, **near, parameters=parameters)
        except kn.KaneError:
            continue
        yield {"q": state.q, "u": state.u, "parameters": parameters}
        found += 1
        if found == count:
            return


def compared(eom, run, end, samples, given, inputs, method):
    """Whether a motion is that of `simulate`, of which rows are the same bits; None where that asked Python."""
    step = {"max_step": 1e-3} if run.told["fixed"] else {}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        sol = kn.simulate(
            eom,
            (0, end),
            samples=samples,
            method=method,
            settings=EXACT,
            rtol=1e-9,
            atol=1e-9,
            inputs=inputs,
            **step,
            **given,
        )
    found = run.motion(
        sol.states[0], [sol.parameters[s] for s in eom.parameters], list(inputs.values()), end, samples, **step
    )
    chosen_at_start = any(t == 0 and e not in eom.events for e, t in sol.events)  # other dependent speeds, by Python
    if found.looks or found.code not in ("END", "EVENT") or chosen_at_start:
        return None
    assert (found.code == "EVENT") == (sol.status == "event")
    assert [(t, n) for t, n in found.events] == [(t, e.name) for e, t in sol.events if e in eom.events]
    apart = [row for row in found.jumps if row[0] > 0]
    instants = {float(row[0]) for row in apart}
    rows = {t: x for t, x in zip(found.t, found.states, strict=True) if t not in instants}
    times = [t for t in sol.t if t not in instants]
    assert list(rows) == times
    at = [k for k, t in enumerate(sol.t) if t not in instants]
    assert np.array_equal(bits(np.array(list(rows.values()))), bits(sol.states[at]))
    n = run.told["n"]
    for row in apart:
        where = np.flatnonzero(sol.t == row[0])
        assert np.array_equal(bits(row[2 : 1 + n]), bits(sol.states[where[0]]))
        if len(where) > 1:
            assert np.array_equal(bits(row[2 + n : 1 + 2 * n]), bits(sol.states[where[-1]]))
    return True


@pytest.mark.grows
@pytest.mark.parametrize(
    "name",
    [pytest.param(n, marks=() if n in QUICK else pytest.mark.slow) for n in GALLERY if n not in CONTACTS | set(ASKS)],
)
def test_motions_of_the_gallery_are_those_of_simulate(name, rng):
    """With events and constraints; nearly nowhere is Python asked."""
    eom = kn.derive(load(name).system())
    method = "tsit5" if name in QUICK else "dop853"
    run, same, asked = engine(eom, method), 0, 0
    inputs = dict.fromkeys(eom.inputs, 0.3)
    for given in positions(name, eom, POSITIONS, rng):
        one = compared(eom, run, MOST.get(name, 1.0), 31, given, inputs, method)
        same, asked = same + (one is True), asked + (one is None)
    assert same + asked == POSITIONS
    assert asked <= 0.25 * POSITIONS


@pytest.mark.slow
@pytest.mark.parametrize("method", ["rk4", "midpoint", "tsitpap8", "vern9"])
def test_methods(method, rng):
    """Steps of one length, implicit ones, and other tableaus."""
    eom = kn.derive(load("double_pendulum").system())
    run = engine(eom, method)
    for given in positions("double_pendulum", eom, 2, rng):
        assert compared(eom, run, 1.0, 31, given, {}, method)


def test_bounces(rng):
    """Events that set the state, one that is noted, one that ends the motion; with inputs an engine is used again and again."""
    eom = kn.derive(ball())
    run = engine(eom, "tsit5")
    for height in (1.0, 1.3, 1.0):
        assert compared(eom, run, 9.0, 61, {"q": [height], "u": [0.5]}, {}, "tsit5")


BRIEF = {"woodpecker": 0.3, "newtons_cradle": 0.3}
"""Ends of motions (s) with contacts that have many modes."""
OWN_MODES = {"skidding_bicycle": "wheels hold one body together", "slider_crank_with_clearance": "81 modes"}
"""Those of the gallery of which a module has some modes at most: those that are told."""


def contact_positions(name, eom, count, rng):
    """Starts and parameters near those of the gallery from which a motion sets out."""
    start = load(name).START
    for k in range(10 * count):
        width = 0.0 if k == 0 else 0.05
        speeds = {s: v * rng.uniform(1 - width, 1 + width) for s, v in start["u"].items()}
        change = rng.uniform(1 - width, 1 + width, len(eom.parameters))
        given = {**start, "u": speeds} | {
            "parameters": {
                s: min(float(s.default) * x, 1.0) if s.name.startswith("e") else float(s.default) * x
                for s, x in zip(eom.parameters, change, strict=True)
            }
            if k % 2 == 0
            else {}
        }
        yield given


@pytest.mark.grows
@pytest.mark.parametrize(
    "name",
    [pytest.param(n, marks=() if n == "mass_on_belt" else pytest.mark.slow) for n in sorted(CONTACTS - set(OWN_MODES))],
)
def test_contacts_of_the_gallery_are_those_of_simulate(name, rng):
    """From mode to mode, with impacts: events, modes and bits are those of kernels that know the modes."""
    eom = kn.derive(load(name).system())
    method = "tsit5" if name == "mass_on_belt" else "dop853"
    run, same, asked = engine(eom, method), 0, 0
    given = {"settings": EXACT, "method": method, "rtol": 1e-9, "atol": 1e-9, "samples": 31}
    end = BRIEF.get(name, 1.0)
    for start in contact_positions(name, eom, POSITIONS, rng):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            try:
                kn.simulate(eom, (0, end), **start, **given)
                sol = kn.simulate(eom, (0, end), **start, **given)
            except kn.KaneError:
                continue
        values = {s.name: v for s, v in sol.parameters.items()}
        p = [float(values[s]) for s, *_ in run.told["symbols"]["p"]]
        r = [float(sol.inputs[s](0.0)) for s in eom.inputs]
        found = run.contacts(sol_start(eom, start), p, r, end, 31)
        if found.code not in ("END", "EVENT"):
            asked += 1
            continue
        same += 1
        assert found.events == [(t, e.name) for e, t in sol.events if not e.name.endswith(" rests")]
        assert np.array_equal(found.t, sol.t)
        assert np.array_equal(bits(found.states), bits(sol.states))
        if same + asked == POSITIONS:
            break
    assert same + asked == POSITIONS
    assert asked <= 0.25 * POSITIONS


def sol_start(eom, start):
    """The state that is given, before impacts at its instant."""
    q, u = ({str(s): float(v) for s, v in start[which].items()} for which in ("q", "u"))
    return [*(q[s.name] for s in eom.coordinates), *(u[s.name] for s in eom.speeds)]


def test_starts_that_are_none():
    """Off the constraints, at the threshold of an event, without time: `begin` says which."""
    four_bar = kn.derive(load("four_bar").system())
    run = engine(four_bar, "tsit5")
    state = kn.assemble(four_bar, **load("four_bar").START)
    x, p = np.array([*state.q.values(), *state.u.values()]), [float(s.default) for s in four_bar.parameters]
    assert run.begin(x, p, [], 1.0, 11)[0] == "BEGUN"
    said, told = run.begin(x + np.eye(len(x))[0] * 1e-3, p, [], 1.0, 11)
    assert said == "OPEN"
    assert abs(told[1]) > 1e-5
    for end, samples in ((0.0, 11), (np.nan, 11), (np.inf, 11), (1.0, 1)):
        assert run.begin(x, p, [], end, samples)[0] == "WRONG"
    bounce = kn.derive(ball())
    said, told = engine(bounce, "tsit5").begin([0.0, 1.0], [float(s.default) for s in bounce.parameters], [], 1.0, 11)
    assert (said, bounce.events[int(told[0])].name) == ("ON_THRESHOLD", "bounce")


def test_what_is_refused():
    """Contacts that hold one body together, methods of many stages at once."""
    with pytest.raises(kn.KaneError, match="modes with redundant contacts of one rigid body"):
        emit_simulator_wasm(kn.derive(load("bouncing_ball").system()).compile(), modes=[(5,)])
    with pytest.raises(kn.KaneError, match=r"for a module of WebAssembly, got 'gauss16'"):
        emit_simulator_wasm(kn.derive(load("pendulum").system()).compile(), "gauss16")
    for samples in (0, 1, -1, 2.5, True, "3", None, 10**9):  # 0 and −1 were modules that write over their own memory
        for name in ("pendulum", "bouncing_ball"):
            with pytest.raises(kn.ProgramError, match="samples= a whole number from 2"):
                emit_simulator_wasm(kn.derive(load(name).system()).compile(), samples=samples)


def test_the_module_tells_what_stands_where():
    """Defaults, events, functions that are the engine's, room for samples; and it is small."""
    eom = kn.derive(load("muscle_arm").system())
    raw = emit_simulator_wasm(eom.compile(name="arm"), "tsit5", 50)
    told = Engine(raw).told
    assert told["library"] == ["exp", "tanh"]
    assert told["samples"] == 50
    assert [name for name, *_ in told["symbols"]["p"]] == [s.name for s in eom.parameters]
    assert len(raw) < 20_000


def browser_motion(page, raw, given):
    """What the page's engine gives: code, times and states as bytes in base64, milliseconds of a warm run."""
    return page.evaluate(
        """async ([module, given]) => {
          const engine = await KaneEngine.from(module);
          const text = (numbers) => btoa(String.fromCharCode(...new Uint8Array(numbers.buffer)));
          let motion, best = Infinity;
          for (let k = 0; k < 20; k++) {
            const start = performance.now();
            motion = engine.simulate(given);
            best = Math.min(best, performance.now() - start);
          }
          return [motion.code, text(motion.times), text(motion.states), best];
        }""",
        [base64.b64encode(raw).decode(), given],
    )


@pytest.mark.slow
def test_chromium_gives_the_same_bits_in_time(rng):
    """Also under a policy that admits WebAssembly alone: a disk within 10 ms, ten rods within 40 ms, with 601 frames."""
    cases = {
        "disk": (load("pure_rolling_disk").system(), load("pure_rolling_disk").START, 10.0),
        "ten rods": (load("pendulums").system(10), {"q": [0.5] * 10, "u": [0.0] * 10}, 40.0),
        "four-bar": (load("four_bar").system(), load("four_bar").START, 10.0),
        "belt": (load("mass_on_belt").system(), load("mass_on_belt").START, 10.0),
        "ball": (ball(), {"q": [1.0], "u": [0.5]}, 10.0),
    }
    script = files("kane.present").joinpath("templates/engine.js").read_text(encoding="utf-8")
    policy = "default-src 'none'; script-src 'unsafe-inline' 'wasm-unsafe-eval'"
    head = f'<meta http-equiv="Content-Security-Policy" content="{policy}"><script>{script}\nwindow.KaneEngine = KaneEngine</script>'
    with chromium() as browser:
        page = browser.new_page()
        said = []
        page.on("console", lambda m: said.append(m.text))
        page.on("pageerror", lambda e: said.append(str(e)))
        page.set_content(head)
        for name, (system, start, most) in cases.items():
            eom = kn.derive(system)
            state = kn.assemble(eom, **start)
            sol = kn.simulate(
                eom, (0, 5), q=state.q, u=state.u, samples=601, method="dop853", settings=EXACT, rtol=1e-9, atol=1e-9
            )
            raw = emit_simulator_wasm(eom.compile(contract=False))
            values = {s.name: float(v) for s, v in sol.parameters.items()}
            given = {"state": sol.states[0].tolist(), "parameters": values, "end": 5, "samples": 601}
            code, t, x, took = browser_motion(page, raw, given)
            t, x = (np.frombuffer(base64.b64decode(text)) for text in (t, x))
            x = x.reshape(len(t), -1)[:, :-1]
            at = [k for k, time in enumerate(sol.t) if np.count_nonzero(sol.t == time) == 1 and time in t]
            where = np.searchsorted(t, sol.t[at])
            assert code == ("EVENT" if sol.status == "event" else "END"), name
            assert len(at) >= 0.95 * len(t), name
            assert np.array_equal(bits(x[where]), bits(sol.states[at])), name
            assert took <= most, name
        with pytest.raises(Exception, match="Expected one of e in the parameters, got mass"):
            browser_motion(page, raw, {"state": [1.0, 0.5], "parameters": {"mass": 2}, "end": 1})
        assert said == []

# SPDX-License-Identifier: BSD-3-Clause
"""Motions of modules of WebAssembly, run by wasmtime, as a page runs them (`present/templates/engine.js`)."""

from dataclasses import dataclass, field

import numpy as np

from tests.program.hosted import Hosted


@dataclass
class Motion:
    """Times of the samples, the states there, events (t, name), states before and after what they changed, why it ended."""

    t: np.ndarray
    states: np.ndarray
    code: str
    looks: int = 0
    events: list = field(default_factory=list)
    jumps: list = field(default_factory=list)


class Engine(Hosted):
    """`motion(x, p, r, end, samples)` from a state, values of parameters and of inputs."""

    def named(self, name, length):
        """An array of the module."""
        return self.array(self.told["at"][name], length)

    def begin(self, x, p, r, end, samples, tolerances=(1e-9, 1e-9), max_step=np.inf):
        """What `begin` gives, by name, and what it tells."""
        told, slots = self.told, self.told["slots"]
        for name, values in (("y", x), ("p", p), ("r", r)):
            self.named(name, len(values))[:] = values
        self.s = self.named("s", len(slots))
        for slot, value in zip(("END", "RTOL", "ATOL", "LONGEST"), (end, *tolerances, max_step), strict=True):
            self.s[slots[slot]] = value
        back = self.call("begin", samples)
        return next(name for name, code in told["begun"].items() if code == back), self.named("told", 3).copy()

    def motion(self, x, p, r, end, samples, limit=1000, **more):
        """The motion to its end."""
        begun, _ = self.begin(x, p, r, end, samples, **more)
        assert begun == "BEGUN"
        told, slots, n = self.told, self.told["slots"], self.told["n"]
        codes = {code: name for name, code in told["codes"].items()}
        found = Motion(np.zeros(0), np.zeros(0), "")
        while True:
            found.code = codes[self.call("run", limit, samples - 1)]
            self.collect(found)
            if found.code == "LOOK" and told["constraints"] and self.call("look"):
                found.looks += 1
            elif found.code not in ("LIMIT", "FULL"):
                break
        count = int(self.s[slots["SAMPLE"]]) + 1
        found.t = np.append(0.0, self.named("times", count - 1))
        found.states = self.named("states", count * n).reshape(count, n)[:, :-1].copy()
        return found

    def contacts(self, x, p, r, end, samples, **more):
        """The motion from mode to mode: times and states at both ends of each mode and at samples within, why it ended."""
        begun, _ = self.begin(x, p, r, end, samples, **more)
        assert begun == "BEGUN"
        told, n = self.told["contacts"], self.told["n"]
        back, row, width = told["back"], told["row"], told["width"]
        times, states = (self.named(name, count) for name, count in (("times", samples), ("states", samples * n)))
        states = states.reshape(samples, n)[1:]
        found, parts, said, enter = Motion(np.zeros(0), np.zeros(0), ""), [], back["FULL"], 2
        found.modes = []
        while said == back["FULL"]:
            given = {"enter": enter, "most": 1_000_000}
            said, enter = self.call("run", *(given[name] for name in told["asked"])), 1
            count, noted = map(int, self.named("records", 2))
            rows = self.named("records", 2 + count * width)[2:].reshape(count, width).copy()
            met, done = self.named("noted", 2 * noted).reshape(noted, 2), 0
            for own in rows:
                t0, t1, mode, first, last = (
                    own[row[name]] for name in ("BEGIN", "END", "MODE", "FIRST_SAMPLE", "SAMPLE")
                )
                within = [k for k in range(int(first), int(last)) if t0 < times[k] < t1]
                parts.append((np.r_[t0, times[within], t1], np.vstack([own[-2 * n : -n], states[within], own[-n:]])))
                found.modes.append((t0, told["words"][int(mode)]))
                until = int(own[row["NOTED"]])
                found.events += [(float(t), told["events"][int(mode)][int(k)]) for t, k in met[done:until]]
                done = until
        found.code = next(name for name, code in back.items() if code == said)
        if parts:
            found.t = np.concatenate([t for t, _ in parts])
            found.states = np.vstack([y for _, y in parts])[:, :-1]
        return found

    def collect(self, found):
        """What was noted of events."""
        slots, n = self.told["slots"], self.told["n"]
        if self.told["events"] and self.s[slots["LOGGED"]]:
            logged, jumped = int(self.s[slots["LOGGED"]]), int(self.s[slots["JUMPS"]])
            rows = self.named("log", 2 * logged).reshape(logged, 2)
            found.events += [(float(t), self.told["events"][int(k)]) for t, k in rows]
            found.jumps += list(self.named("jumps", (2 * n + 2) * jumped).reshape(jumped, -1).copy())
            self.s[slots["LOGGED"]] = self.s[slots["JUMPS"]] = 0.0

# SPDX-License-Identifier: BSD-3-Clause
"""Modules of WebAssembly run by wasmtime: what they tell, their memory as doubles, their functions. `Math` is the C library's."""

import ctypes
import json

import numpy as np

from kane.program import Callee, Integer, Module, add_kernel
from tests.peer import require
from tests.program.programs import by_port


def told(raw):
    """What the first section of a module says."""
    assert raw[:9] == b"\0asm\x01\0\0\0\0"

    def number(at):
        value = shift = 0
        while True:
            byte, at = raw[at], at + 1
            value, shift = value | (byte & 127) << shift, shift + 7
            if byte < 128:
                return value, at

    size, at = number(9)
    length, name = number(at)
    assert raw[name : name + length] == b"kane"
    return json.loads(raw[name + length : at + size])


class Hosted:
    """A module that runs: `call(name, …)`, `array(at, length)`."""

    def __init__(self, raw, config=None):
        wasmtime = require("wasmtime")
        self.told, engine = told(raw), wasmtime.Engine(config or _near())
        self.store, module = wasmtime.Store(engine), wasmtime.Module(engine, raw)
        imports = [wasmtime.Func(self.store, i.type, _library(i.name, len(i.type.params))) for i in module.imports]
        self.exports = wasmtime.Instance(self.store, module, imports).exports(self.store)

    def call(self, name, *given):
        """A function."""
        return self.exports[name](self.store, *given)

    def array(self, at, length):
        """Doubles of the memory, from a place on."""
        memory = self.exports["memory"]
        first = ctypes.addressof(memory.data_ptr(self.store).contents)
        assert at + 8 * length <= memory.data_len(self.store)
        return np.ctypeslib.as_array((ctypes.c_double * length).from_address(first + at))


def _near():
    """Settings with which memory takes no gigabytes of addresses: they would part what LLVM loads, which it then refuses."""
    config = require("wasmtime").Config()
    for what in ("reservation", "reservation_for_growth", "guard_size"):
        setattr(config, f"memory_{what}", 0)
    return config


def _library(name, count):
    function = getattr(ctypes.CDLL("libm.so.6"), name)
    function.restype, function.argtypes = ctypes.c_double, [ctypes.c_double] * count
    return function


def from_wasm(program, raw):
    """A function of a routine's name and rows of all inputs."""
    hosted = Hosted(raw)
    at = hosted.told["ports"]

    def results(name, rows):
        found = []
        for row in rows:
            given = by_port(program, row)
            for port, place in at.items():
                hosted.array(place, len(given[port]))[:] = given[port]
            passed = [float(given[p.name][0]) if p.scalar else at[p.name] for p in program.ports]
            hosted.call("hoist", *(at[p.name] for p in program.hoisted_ports), hosted.told["h"])
            hosted.call(name, *passed, hosted.told["h"], hosted.told["out"][name])
            found.append(hosted.array(hosted.told["out"][name], len(program.routine(name).results)).copy())
        return np.array(found)

    return results


def kernel_module(kernel, lengths):
    """The module of a kernel that calls no routine, and has arrays of these lengths, `at` the places that its section "kane" tells."""
    module = Module({})
    places = {name: module.room(length, 64) for name, length in lengths.items()}
    module.exports[kernel.name] = add_kernel(module, kernel, places, {})
    return module.raw({"at": places})


def in_wasm(kernel):
    """A function of a kernel's arguments by name."""
    assert not any(isinstance(a, Callee) for a in kernel.arguments)

    def call(given):
        arrays = {name: v for name, v in given.items() if isinstance(v, np.ndarray)}
        hosted = Hosted(kernel_module(kernel, {name: v.size for name, v in arrays.items()}))
        places = {name: hosted.array(hosted.told["at"][name], v.size) for name, v in arrays.items()}
        for name, v in arrays.items():
            places[name][:] = v.reshape(-1)
        back = hosted.call(kernel.name, *(given[a.name] for a in kernel.arguments if isinstance(a, Integer)))
        for name, v in arrays.items():
            v.reshape(-1)[:] = places[name]
        return back

    return call

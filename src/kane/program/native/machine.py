# SPDX-License-Identifier: BSD-3-Clause
"""Machine code through llvmlite: LLVM text is compiled to an object file and linked.

A `Library` owns the code, which is freed with it. Entries hold a reference to their library, and addresses never leave this package.

Any thread may compile, link and free libraries: a reentrant lock of llvmlite serializes access to LLVM (the garbage collector may free
a library during a compilation in the same thread). Each compilation has its own context, and few libraries share a linker, so that all
their memory is released.
"""

import atexit
import ctypes
import os
import sys
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass
from functools import cache
from itertools import count
from typing import Any

from kane.errors import Attributes, ProgramError, warn
from kane.program.emit.llvm import emit_llvm, hoists
from kane.program.native import store
from kane.program.program import Program
from kane.progress import collecting_seldom, working

_OPTIONS = {"opt": 2, "reloc": "pic", "codemodel": "small" if sys.platform == "linux" else "jitdefault"}
"""On Linux the small code model: a module's constants are linked within reach of an offset; elsewhere their addresses are loaded."""
_LONG = 200_000
"""Length of a text from which on LLVM selects and schedules at level 1: twice as fast, and the code is as fast."""
_LEFT_OUT = {_LONG: "disable-lsr", 600_000: "disable-machine-licm"}
"""Options that leave a pass out of texts of this length or more: strength reduction of loops; constants before loops, which fill the
registers of long kernels, so that their allocation takes twice the time and the code is no faster (that of short ones is, by 6 %)."""


@dataclass(frozen=True, slots=True)
class Settings(Attributes):
    """Compilation settings; the fields are arguments of `kn.compile`, and motions and analyses accept them as `settings=`.

    `contract` permits one rounding of a·b + c (FMA) and shared reciprocals. `cpu` is "host", or "generic" for the baseline of the
    architecture with additional `features`. `cache` keeps the code in the user's cache folder. `optimize` reduces operations if
    `contract` permits different rounding.
    """

    contract: bool = True
    cpu: str = "host"
    features: str = ""
    cache: bool = True
    optimize: bool = True


@dataclass(frozen=True, slots=True)
class Processor:
    """The target processor: LLVM's triple, CPU name and features ("+avx2,+fma,…")."""

    triple: str
    cpu: str
    features: str

    @property
    def lanes(self) -> int:
        """The number of doubles in a vector register."""
        have = set(self.features.split(","))
        return 8 if "+avx512f" in have else 4 if have & {"+avx", "+avx2"} else 2


@cache
def _llvm() -> Any:
    from llvmlite import binding

    binding.initialize_native_target()
    binding.initialize_native_asmprinter()
    alone = _alone()
    # After fork, the child would wait forever for a lock held by a thread that it does not have.
    if hasattr(os, "register_at_fork"):
        os.register_at_fork(before=alone.__enter__, after_in_parent=alone.__exit__, after_in_child=alone.__exit__)
    atexit.register(_end)
    return binding


_ended = threading.Event()


def _end() -> None:
    """Before LLVM's globals are destroyed at exit: waits until no thread uses LLVM, then admits only the main thread."""
    with _alone():
        _ended.set()


def _alone() -> Any:
    """The reentrant lock of llvmlite, which admits one thread at a time to LLVM."""
    from llvmlite import binding

    return getattr(binding.ffi.lib, "_lock", None) or nullcontext()


@contextmanager
def _inside() -> Iterator[Any]:
    """LLVM under the lock; raises if the interpreter is shutting down and this is not the main thread."""
    llvm = _llvm()
    with _alone():
        if _ended.is_set() and threading.current_thread() is not threading.main_thread():
            raise ProgramError(
                "Expected a running interpreter to compile in, got one that is ending: join threads first."
            )
        yield llvm


_V2 = "+cx16,+popcnt,+sse3,+sse4.1,+sse4.2,+ssse3"
_V3 = f"{_V2},+avx,+avx2,+bmi,+bmi2,+f16c,+fma,+lzcnt,+movbe,+xsave"
LEVELS = {"x86-64-v2": _V2, "x86-64-v3": _V3, "x86-64-v4": f"{_V3},+avx512bw,+avx512cd,+avx512dq,+avx512f,+avx512vl"}
"""Processors for the environment variable KANE_CPU, with their features: microarchitecture levels of the x86-64 psABI."""


@cache
def host() -> Processor:
    """The processor of this process, or the level that KANE_CPU names."""
    llvm = _llvm()
    here = Processor(llvm.get_process_triple(), llvm.get_host_cpu_name(), llvm.get_host_cpu_features().flatten())
    level = os.environ.get("KANE_CPU", "")
    if not level:
        return here
    features = set(here.features.split(","))
    usable = [name for name, needed in LEVELS.items() if features.issuperset(needed.split(","))]
    if level not in usable:
        raise ProgramError(
            f"Expected the environment variable KANE_CPU as a processor whose code {here.cpu} can run, one of "
            f"{', '.join(usable) or 'none'}, got {level!r}. Leave it unset to use the processor itself."
        )
    return Processor(here.triple, level, LEVELS[level])


def target(cpu: str = "host", features: str = "") -> Processor:
    """The host, or, if `cpu` is "generic", the baseline of its architecture with `features` ("+avx2,+fma").

    Raises
    ------
    ProgramError
        if the code could not run here: a different processor, or a feature that the host lacks
    """
    here = host()
    if cpu == "generic":  # first, because LLVM reports this name for unknown processors too
        chosen = Processor(here.triple, "generic", "")
    elif cpu in ("host", here.cpu):
        chosen = here
    else:
        raise ProgramError(
            f'Expected cpu to be "host", "generic" or {here.cpu!r}, got {cpu!r}: code for it cannot run here.'
        )
    if not isinstance(features, str):
        raise ProgramError(f'Expected features as one text, "+avx2,+fma", got {features!r}.')
    asked = [f.strip() for f in features.split(",") if f.strip()]
    own = [f for f in here.features.split(",") if f[:1] == "+"]
    missing = [f for f in asked if f not in own]
    if missing:
        raise ProgramError(
            f'Expected features that this processor has, each as "+name", got {", ".join(missing)}. It has '
            f"{', '.join(sorted(f[1:] for f in own))}."
        )
    return Processor(chosen.triple, chosen.cpu, ",".join(f for f in (chosen.features, *asked) if f))


_SHARED = 16
"""Libraries that share a linker: making one takes longer than linking, but it keeps some 10 kB of each until the last is freed."""
_numbers = count()


@cache
def _linker() -> Any:
    return _llvm().create_lljit_compiler()


def _place() -> tuple[Any, str]:
    """The linker of the next library, and the name that it has there; called under the lock."""
    number = next(_numbers)
    if number % _SHARED == 0:
        _linker.cache_clear()
    return _linker(), f"kane{number}"


class Library:
    """Linked machine code.

    Raises
    ------
    ProgramError
        if the image is not an object file, lacks one of the symbols, or needs a symbol that this process lacks
    """

    __slots__ = ("__weakref__", "_tracker")

    def __init__(self, image: bytes, symbols: Sequence[str]) -> None:
        with _inside() as llvm:
            builder = llvm.JITLibraryBuilder().add_object_img(image).add_current_process()
            for symbol in symbols:
                builder.export_symbol(symbol)
            try:
                self._tracker = builder.link(*_place())  # it owns its share of the linker
            except RuntimeError as error:
                raise ProgramError(f"Expected code that links and has {', '.join(symbols)}, got: {error}") from error

    def address(self, symbol: str) -> int:
        """The address of a function, valid as long as this library exists."""
        return int(self._tracker[symbol])

    def function(self, symbol: str, result: Any, *arguments: Any, brief: bool = False) -> Any:
        """A ctypes callable, which keeps the library alive; if `brief`, it does not release the GIL."""
        kind = ctypes.PYFUNCTYPE if brief else ctypes.CFUNCTYPE
        function = kind(result, *arguments)(self.address(symbol))
        function._library = self  # type: ignore[attr-defined]  # ctypes functions take attributes
        return function


_turns = [threading.RLock() for _ in range(64)]
"""Locks by a prefix of the key: threads that start the same motions request the same kernels at the same time."""


def _renew_turns() -> None:
    _turns[:] = [threading.RLock() for _ in _turns]


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_renew_turns)  # threads that hold a lock do not exist in the child


def compile_text(text: str, on: Processor, symbols: Sequence[str], cached: bool = True, loops: bool = False) -> Library:
    """The library of an LLVM module, from the cache if present; `loops` runs LLVM's loop passes."""
    options = [*(f"{name}={value}" for name, value in _options(text).items()), *(_IMPROVEMENTS if loops else [])]
    key = store.key(text, on.triple, on.cpu, on.features, *options, *versions())
    if not cached:
        return Library(object_code(text, on, loops), symbols)
    with _turns[int(key[:4], 16) % len(_turns)]:  # a thread that waits for the same text then finds it in the cache
        image = store.read(key)
        if image is not None:
            try:
                return Library(image, symbols)
            except ProgramError as error:
                warn(f"{error} It is the cache entry {key}. Compiling anew.")
        image = object_code(text, on, loops)
        library = Library(image, symbols)
        store.write(key, image)
        return library


def build_library(programs: Sequence[Program], settings: Settings) -> Library:
    """Emits and compiles programs as one module, or takes it from the cache. The names of all routines must differ."""
    with working("Compiling"), collecting_seldom():
        on = target(settings.cpu, settings.features)
        text = emit_llvm(programs, settings.contract, on.lanes)
        routines = [r.name for program in programs for r in program.routines]
        symbols = [*hoists(programs), *(f"{name}{entry}" for name in routines for entry in ("", ".call", ".batch"))]
        return compile_text(text, on, symbols, settings.cache)


def _options(text: str) -> dict[str, Any]:
    return _OPTIONS | {"opt": 1} if len(text) > _LONG else _OPTIONS


@cache
def _machine(on: Processor, **options: Any) -> Any:
    """LLVM's code generator for a processor: making one takes longer than a short text."""
    return _llvm().Target.from_triple(on.triple).create_target_machine(cpu=on.cpu, features=on.features, **options)


def object_code(text: str, on: Processor, loops: bool = False) -> bytes:
    """The object file of an LLVM module.

    Raises
    ------
    ProgramError
        if LLVM does not accept the text
    """
    with _inside() as llvm, llvm.create_context() as context:
        try:
            with llvm.parse_assembly(text, context) as module:
                module.verify()
                machine = _machine(on, **_options(text))
                _transform(llvm, machine, module, _IMPROVEMENTS if loops else _INLINING, int(loops))
                with _shortened(llvm, text):
                    return bytes(machine.emit_object(module))
        except RuntimeError as error:
            raise ProgramError(f"Expected text that LLVM reads and compiles for {on.cpu}, got: {error}") from error


@contextmanager
def _shortened(llvm: Any, text: str) -> Iterator[None]:
    """Passes are left out of a long text, by options of the process, which are reset before the lock is left."""
    names = [name for length, name in _LEFT_OUT.items() if len(text) > length]
    try:
        for name in names:
            llvm.set_option("", f"-{name}=true")
        yield
    finally:
        for name in names:
            llvm.set_option("", f"-{name}=false")


_INLINING = ["always_inliner"]
"""The LLVM pass for Programs, which inlines sine and cosine; others would find nothing to improve (docs/develop/decisions.md)."""
_IMPROVEMENTS = ["sroa", "simplify_cfg", "new_gvn", "instruction_combine", "loop_simplify", "simplify_cfg"]
"""LLVM passes for kernels, which do not change rounding: promotion of cells to registers and what then is constant or equal; other
passes of an optimization level gained nothing."""


def _transform(llvm: Any, machine: Any, module: Any, names: Sequence[str], level: int) -> None:
    """Runs passes on a module."""
    builder = llvm.create_pass_builder(machine, llvm.create_pipeline_tuning_options(speed_level=level))
    passes = llvm.create_new_module_pass_manager()
    for name in names:
        getattr(passes, f"add_{name}_pass")()
    passes.run(module, builder)


@cache
def versions() -> tuple[str, ...]:
    """The versions on which machine code depends, besides text and target."""
    import llvmlite

    return (f"llvmlite {llvmlite.__version__}", "LLVM " + ".".join(map(str, _llvm().llvm_version_info)))

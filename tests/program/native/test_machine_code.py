# SPDX-License-Identifier: BSD-3-Clause
"""Text to machine code: targets, linking, what the cache's key covers, and how long code lives."""

import ctypes
import gc
import pickle
import re
import sys
import weakref

import numpy as np
import pytest

import kane as kn
from kane import Handle, Settings
from kane.errors import KaneWarning, ProgramError
from kane.gallery.pendulums import system as chain
from kane.motion import INTEGRATORS
from kane.program import (
    CompiledKernel,
    Library,
    Processor,
    compile_text,
    emit_llvm,
    machine,
    object_code,
    store,
    target,
)
from tests.program.child import child

SQUARE = """
define double @f(double %x) {
  %y = fmul double %x, %x
  ret double %y
}
"""
OTHER = SQUARE.replace("@f", "@g")
UNMET = """
declare double @kane_has_no_such_function(double)
define double @f(double %x) {
  %y = call double @kane_has_no_such_function(double %x)
  ret double %y
}
"""
TWO = np.array([0.1, 0.2, 0.3, 0.4])


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.setenv("KANE_CACHE", str(tmp_path / "objects"))
    return tmp_path / "objects"


def number(library, x, name="f"):
    return library.function(name, ctypes.c_double, ctypes.c_double)(x)


def refuse(*_, **__):
    raise AssertionError("compiled")


class TestTarget:
    def test_host(self):
        here = machine.host()
        assert target() == target("host") == target(here.cpu) == here
        assert here.lanes in (2, 4, 8)

    @pytest.mark.parametrize("cpu", ["skylake-avx512", "i386", "apple-m1", "no-such", "", "Host", "native", "x86-64"])
    def test_another_processor_is_refused(self, cpu, monkeypatch):
        known = machine.host()
        monkeypatch.setattr(machine, "host", lambda: Processor(known.triple, "this-one", known.features))
        with pytest.raises(ProgramError, match=f'Expected cpu to be "host", "generic" or .*, got {cpu!r}'):
            target(cpu)
        with pytest.raises(ProgramError, match="cannot run here"):
            kn.derive(chain(1)).compile(cpu=cpu)

    def test_generic_has_no_features(self):
        generic = target("generic")
        assert (generic.cpu, generic.features, generic.lanes) == ("generic", "", 2)
        assert generic.triple == machine.host().triple

    def test_generic_where_llvm_does_not_know_the_host(self, monkeypatch):
        """LLVM then calls the host "generic" too, and yet lists its features."""
        monkeypatch.setattr(machine, "host", lambda: Processor("x86_64-unknown-linux-gnu", "generic", "+avx,+avx512f"))
        assert target("generic").features == ""
        assert target("host").lanes == 8

    @pytest.mark.parametrize(("features", "lanes"), [("", 2), ("+avx", 4), ("+avx,-avx512f", 4), ("+avx,+avx512f", 8)])
    def test_lanes(self, features, lanes):
        assert Processor("", "", features).lanes == lanes


class TestFeatures:
    def test_added_to_the_generic_processor(self, monkeypatch):
        monkeypatch.setattr(machine, "host", lambda: Processor("t", "this-one", "+avx,+avx2,+fma,-avx512f"))
        assert target("generic", "+avx2, +fma") == Processor("t", "generic", "+avx2,+fma")
        assert target("generic", "+avx2").lanes == 4

    @pytest.mark.parametrize("feature", ["+avx512f", "+no-such", "avx2", "-no-such", "-avx2", "-sse2", "+"])
    def test_one_that_the_host_lacks_is_refused(self, feature, monkeypatch):
        monkeypatch.setattr(machine, "host", lambda: Processor("t", "this-one", "+avx,+avx2,+fma,-avx512f"))
        message = f'Expected features that this processor has, each as "+name", got {feature}. It has avx, avx2, fma.'
        with pytest.raises(ProgramError, match=re.escape(message)):
            target("generic", f"+avx2,{feature}")
        with pytest.raises(ProgramError, match="Expected features that this processor has"):
            kn.derive(chain(1)).compile(cpu="generic", features=feature)

    def test_results_keep_their_bits(self):
        eom = kn.derive(chain(3))
        x = np.random.default_rng(1).uniform(-1.5, 1.5, (20, 6))
        some = ",".join(f for f in ("+avx2", "+fma") if f in machine.host().features.split(","))
        host = eom.compile(contract=False).rhs(0.0, x)
        assert np.array_equal(eom.compile(contract=False, cpu="generic", features=some).rhs(0.0, x), host)

    def test_type(self):
        with pytest.raises(ProgramError, match=re.escape('Expected features as one text, "+avx2,+fma", got [')):
            kn.derive(chain(1)).compile(features=["+avx2"])


class TestGeneric:
    def test_same_bits_as_the_host_without_contraction(self):
        eom = kn.derive(chain(3))
        x = np.random.default_rng(1).uniform(-1.5, 1.5, (20, 6))
        host, generic = (eom.compile(contract=False, cpu=cpu).rhs(0.0, x) for cpu in ("host", "generic"))
        assert np.array_equal(host, generic)

    def test_no_vex_instruction(self):
        """Neither register nor mnemonic of AVX; that the host's code has them shows that the search finds them."""
        if "+avx" not in machine.host().features.split(","):
            assert target("generic").features == ""  # nothing to tell apart on this machine
            return
        program = kn.derive(chain(3)).compile().rhs.program
        found = {}
        for cpu in ("host", "generic"):
            on = target(cpu)
            text = emit_llvm([program], True, on.lanes)
            llvm = machine._llvm()
            compiler = llvm.Target.from_triple(on.triple).create_target_machine(
                cpu=on.cpu, features=on.features, **machine._OPTIONS
            )
            with llvm.create_context() as context, llvm.parse_assembly(text, context) as module:
                assembly = compiler.emit_assembly(module)
            assert "mulsd" in assembly
            found[cpu] = re.findall(r"[yz]mm\d|^\s+v[a-z]+\d*[a-z]*\s", assembly, re.MULTILINE)
        assert found["host"]
        assert not found["generic"]


class TestObject:
    def test_same_text_same_bytes(self):
        assert object_code(SQUARE, target()) == object_code(SQUARE, target())

    @pytest.mark.parametrize(
        ("text", "message"),
        [
            ("define double @f(", "expected type"),
            ("define double @f() { ret float 0.0 }", "value doesn't match function result type"),
            (
                f"{SQUARE}\ndefine double @g(double %x) {{ %a = fneg double %b %b = fneg double %a ret double %a }}",
                "dominate",
            ),
        ],
    )
    def test_bad_text(self, text, message):
        with pytest.raises(ProgramError, match=f"Expected text that LLVM reads .*(?s:.)*{message}"):
            object_code(text, target())
        assert number(compile_text(SQUARE, target(), ["f"]), 3.0) == 9.0

    def test_what_a_long_text_goes_without_is_there_for_the_next(self, monkeypatch):
        """LLVM knows what is left out only as options of the process."""
        made, left_out = [], list(machine._LEFT_OUT.values())
        monkeypatch.setattr(machine, "object_code", lambda *given: made.append(object_code(*given)) or made[-1])
        for long in (10**9, 0, 10**9):
            monkeypatch.setattr(machine, "_LONG", long)
            monkeypatch.setattr(machine, "_LEFT_OUT", {long + k: name for k, name in enumerate(left_out)})
            CompiledKernel(INTEGRATORS["rk4"].kernel(), Settings(cache=False))
        usual, brief, again = made
        assert len(brief) < len(usual)
        assert again == usual

    def test_unknown_triple(self):
        with pytest.raises(ProgramError, match="no-such"):
            object_code(SQUARE, Processor("no-such-triple", "", ""))


class TestLink:
    def test_function(self):
        library = Library(object_code(SQUARE, target()), ["f"])
        assert number(library, 1.5) == 2.25
        assert library.function("f", ctypes.c_double, ctypes.c_double, brief=True)(-3.0) == 9.0

    @pytest.mark.parametrize("cut", [0, 3, 64, 300, -64, -1])
    def test_no_object_file(self, cut):
        with pytest.raises(ProgramError, match="Expected code that links and has f, got: "):
            Library(object_code(SQUARE, target())[:cut], ["f"])

    def test_another_symbol(self):
        with pytest.raises(ProgramError, match=r"has f, got: Symbols not found: \[ _?f \]"):
            Library(object_code(OTHER, target()), ["f"])

    def test_function_that_the_process_lacks(self, capfd):
        with pytest.raises(ProgramError, match="Expected code that links and has f"):
            Library(object_code(UNMET, target()), ["f"])
        assert "kane_has_no_such_function" in capfd.readouterr().err

    def test_others_are_not_disturbed(self, capfd):
        before = Library(object_code(SQUARE, target()), ["f"])
        for image in (b"", object_code(OTHER, target()), object_code(UNMET, target())):
            with pytest.raises(ProgramError):
                Library(image, ["f"])
        after = Library(object_code(SQUARE, target()), ["f"])
        assert number(before, 5.0) == number(after, 5.0) == 25.0
        capfd.readouterr()

    def test_one_name_in_two_libraries(self):
        cube = SQUARE.replace("%y = fmul double %x, %x", "%z = fmul double %x, %x\n  %y = fmul double %z, %x")
        two, three = (Library(object_code(text, target()), ["f"]) for text in (SQUARE, cube))
        assert (number(two, 2.0), number(three, 2.0)) == (4.0, 8.0)


class TestCache:
    def test_second_compilation_reads_the_first(self, folder, monkeypatch):
        compile_text(SQUARE, target(), ["f"])
        monkeypatch.setattr(machine, "object_code", refuse)
        assert number(compile_text(SQUARE, target(), ["f"]), 3.0) == 9.0
        with pytest.raises(AssertionError, match="compiled"):
            compile_text(SQUARE, target(), ["f"], cached=False)

    def test_not_asked_for(self, folder):
        compile_text(SQUARE, target(), ["f"], cached=False)
        assert not folder.exists()

    @pytest.mark.parametrize("what", ["text", "triple", "cpu", "features", "versions", "options"])
    def test_key_covers(self, what, monkeypatch):
        keys = []
        monkeypatch.setattr(store, "read", lambda key: keys.append(key) or b"")
        monkeypatch.setattr(machine, "Library", lambda image, symbols: None)
        compile_text("a", Processor("t", "c", "f"), [])
        compile_text("a", Processor("t", "c", "f"), [])
        if what == "versions":
            monkeypatch.setattr(machine, "versions", lambda: ("llvmlite 9", "LLVM 99"))
        if what == "options":
            monkeypatch.setitem(machine._OPTIONS, "opt", 3)
        given = {"text": "a", "triple": "t", "cpu": "c", "features": "f"}
        if what in given:
            given[what] = "other"
        compile_text(given["text"], Processor(given["triple"], given["cpu"], given["features"]), [])
        assert keys[0] == keys[1] != keys[2]

    @pytest.mark.parametrize("text", [OTHER, UNMET])
    def test_entry_that_does_not_link(self, folder, monkeypatch, capfd, text):
        """Right header, right digest, wrong object: a warning, and it is replaced."""
        compile_text(SQUARE, target(), ["f"])
        (entry,) = folder.iterdir()
        store.write(entry.stem, object_code(text, target()))
        with pytest.warns(KaneWarning, match=f"(?s)has f, got: .*cache entry {entry.stem}. Compiling anew"):
            assert number(compile_text(SQUARE, target(), ["f"]), 3.0) == 9.0
        capfd.readouterr()
        monkeypatch.setattr(machine, "object_code", refuse)
        assert number(compile_text(SQUARE, target(), ["f"]), 3.0) == 9.0

    def test_what_does_not_link_is_not_kept(self, folder, capfd):
        with pytest.raises(ProgramError):
            compile_text(UNMET, target(), ["f"])
        assert store.size() == (0, 0)
        capfd.readouterr()

    def test_settings_have_entries_of_their_own(self, folder):
        eom = kn.derive(chain(1))
        for options in ({}, {"contract": False}, {"cpu": "generic"}, {}):
            eom.compile(**options)
        assert len(list(folder.iterdir())) == 3

    @pytest.mark.slow
    def test_second_process_compiles_nothing(self, folder):
        """LLVM neither reads the text nor generates code there; the order of sets and dicts may differ."""
        compiled = kn.derive(chain(2)).compile()
        expected = [compiled.rhs(0.0, TWO), compiled.mass_matrix(0.0, TWO), compiled.forcing(0.0, TWO)]
        code = """
            import numpy as np
            from llvmlite import binding
            import kane as kn
            from kane.gallery.pendulums import system as chain
            from kane.program.native import machine

            def refuse(*_, **__):
                raise AssertionError("compiled")

            machine.object_code = refuse
            binding.parse_assembly = binding.TargetMachine._emit_to_memory = refuse
            compiled = kn.derive(chain(2)).compile()
            x = np.array([0.1, 0.2, 0.3, 0.4])
            for handle in (compiled.rhs, compiled.mass_matrix, compiled.forcing):
                print(handle(0.0, x).tobytes().hex())
        """
        for seed in ("1", "2"):
            found = child(code, folder, PYTHONHASHSEED=seed).split()
            assert found == [a.tobytes().hex() for a in expected]


@pytest.mark.slow
class TestLife:
    """What is called keeps its code; what nothing can call goes. In a child, where a crash is seen."""

    def test_functions_outlive_everything_else(self):
        child("""
            import ctypes, gc
            import numpy as np
            import kane as kn
            from kane.gallery.pendulums import system as chain
            from kane.program.native import machine

            compiled = kn.derive(chain(2)).compile()
            x = np.array([0.1, 0.2, 0.3, 0.4])
            rows = np.tile(x, (3, 1))
            expected, mass = compiled.rhs(0.0, x), compiled.mass_matrix(0.0, x)
            rhs, bound = compiled.rhs, compiled.mass_matrix.__call__
            call, own = compiled.forcing._call, compiled.forcing
            own(0.0, x)
            address, memory = own._free[-1][0], own._free[-1][-1].base
            own = compiled = None
            libraries = [machine.compile_text(f"define double @f() {{ ret double {k}.0 }}", machine.target(), ["f"])
                         for k in range(20)]
            functions = [library.function("f", ctypes.c_double) for library in libraries]
            libraries = None
            for _ in range(3):
                gc.collect()
                kn.derive(chain(1)).compile(contract=False)  # takes what memory has been given back
                assert np.array_equal(rhs(0.0, x), expected)
                assert np.array_equal(rhs(0.0, rows), [expected] * 3)
                assert np.array_equal(bound(0.0, x), mass)
                assert call(address) == 0
                assert [f() for f in functions] == list(range(20))
            functions = functions[::2]
            gc.collect()
            assert [f() for f in functions] == list(range(0, 20, 2))
        """)

    def test_dropped_linkers(self):
        """Each library's linker is dropped at once: the tracker alone keeps the code."""
        child("""
            import ctypes, gc
            from kane.program.native import machine

            image = machine.object_code("define double @f(double %x) { ret double %x }", machine.target())
            kept = []
            for k in range(60):
                library = machine.Library(image, ["f"])
                function = library.function("f", ctypes.c_double, ctypes.c_double)
                if k % 3 == 0:
                    kept.append(function)
            del library, function
            gc.collect()
            assert [f(1.5) for f in kept] == [1.5] * 20
        """)

    def test_library_goes_with_its_last_holder(self):
        handle = kn.derive(chain(1)).compile().rhs
        gone = weakref.ref(handle._library)
        function = handle._call
        handle = None
        gc.collect()
        assert gone() is not None
        function = None
        assert gone() is None, "no cycle: it goes without the collector"
        assert function is None

    @pytest.mark.skipif(sys.platform != "linux", reason="memory in use is read from /proc")
    def test_memory_is_given_back(self):
        child("""
            from kane.program.native import machine

            def used():
                with open("/proc/self/statm") as file:
                    return int(file.read().split()[1]) * 4096

            text = "\\n".join(
                f"define double @f{k}(double %x) {{\\n  %y = fadd double %x, {k}.5\\n  ret double %y\\n}}"
                for k in range(100)
            )
            image = machine.object_code(text, machine.target())
            for part in range(2):
                before = used()
                for _ in range(300):
                    machine.Library(image, ["f1"])
                for k in range(10):
                    machine.object_code(text.replace(".5", f".{5 + part}{k}"), machine.target())
            assert used() - before < 2**20, used() - before
        """)

    def test_pickled_handle(self):
        handle = kn.derive(chain(2)).compile(contract=False, not_finite="raise").rhs
        again = pickle.loads(pickle.dumps(handle))
        assert isinstance(again, Handle)
        assert again.settings == Settings(contract=False)
        assert again.not_finite == "raise"
        assert np.array_equal(again(0.0, TWO), handle(0.0, TWO))


def test_kane_cpu_names_a_lesser_processor(monkeypatch):
    monkeypatch.delenv("KANE_CPU", raising=False)
    own = set(machine.host.__wrapped__().features.split(","))
    for level, lanes in (("x86-64-v2", 2), ("x86-64-v3", 4), ("x86-64-v4", 8)):
        if own.issuperset(machine.LEVELS[level].split(",")):
            monkeypatch.setenv("KANE_CPU", level)
            lesser = machine.host.__wrapped__()
            assert (lesser.cpu, lesser.lanes) == (level, lanes)


def test_kane_cpu_must_be_one_that_this_processor_can_stand_for(monkeypatch):
    monkeypatch.setenv("KANE_CPU", "pentium")
    with pytest.raises(kn.KaneError, match=r"KANE_CPU as a processor whose code .* can run, one of .*, got 'pentium'"):
        machine.host.__wrapped__()

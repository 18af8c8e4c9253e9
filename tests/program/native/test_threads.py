# SPDX-License-Identifier: BSD-3-Clause
"""Threads, processes and the end of the interpreter."""

import ctypes
import multiprocessing
import os
import threading
import time
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor

import numpy as np
import pytest

import kane as kn
from kane.gallery.pendulums import system as chain
from kane.program import machine
from tests.program.child import child

pytestmark = pytest.mark.slow

N, WORKERS = 3, 8
COMPILED = kn.derive(chain(N)).compile()
RHS = COMPILED.rhs
X = np.random.default_rng(7).uniform(-1.5, 1.5, (200, 2 * N))
P = COMPILED.parameters() * np.random.default_rng(8).uniform(0.5, 2.0, (5, 1))

BUSY = """
    import os, signal, threading, time
    from kane.program import machine

    text = "\\n".join(
        f"define double @f{k}(double %x) {{\\n  %y = fadd double %x, {k}.5\\n  %z = fdiv double %y, %x\\n  ret double %z\\n}}"
        for k in range(150)
    )
    def forever():
        while True:
            machine.Library(machine.object_code(text, machine.target()), ["f1"])
    machine.target()
    for _ in range(3):
        threading.Thread(target=forever, daemon=True).start()
    time.sleep(0.05)
"""


def together(work, count=WORKERS):
    """The results of work(0), work(1), … in as many threads that begin at the same time; errors are raised."""
    barrier = threading.Barrier(count)

    def begin(k):
        barrier.wait()
        return work(k)

    with ThreadPoolExecutor(count) as pool:
        return list(pool.map(begin, range(count)))


def same(a, b):
    return a.shape == b.shape and a.tobytes() == b.tobytes()


@pytest.fixture(scope="module")
def expected():
    """What one thread gets, call by call."""
    return [np.array([RHS(0.1 * k, x, p) for x in X]) for k, p in enumerate(P)]


class TestOneHandle:
    def test_calls_one_by_one_and_by_rows(self, expected):
        """Threads whose parameters differ: what is hoisted must be each thread's own."""

        def work(k):
            k %= len(P)
            for _ in range(3):
                assert same(RHS(0.1 * k, X, P[k]), expected[k])
                assert same(np.array([RHS(0.1 * k, x, P[k]) for x in X]), expected[k])

        together(work)

    def test_parameters_change_from_call_to_call(self, expected):
        def work(k):
            for i in range(len(X)):
                j = (i + k) % len(P)
                assert same(RHS(0.1 * j, X[i], P[j]), expected[j][i])

        together(work)

    def test_result_is_not_overwritten_by_others(self):
        results = together(lambda k: [RHS(0.0, x) for x in X[k::WORKERS]])
        alone = [[RHS(0.0, x) for x in X[k::WORKERS]] for k in range(WORKERS)]
        assert same(np.array(results), np.array(alone))

    def test_threads_that_come_and_go(self, expected):
        def work(_):
            for k in range(25):
                found = []
                thread = threading.Thread(target=lambda k=k, found=found: found.append(RHS(0.0, X[k], P[0])))
                thread.start()
                thread.join()
                assert same(found[0], expected[0][k])

        together(work, 4)


class TestCompiling:
    def test_while_others_call(self, tmp_path, monkeypatch):
        """Eight threads: half of them call one handle, half compile others, call and drop them."""
        monkeypatch.setenv("KANE_CACHE", str(tmp_path / "objects"))
        systems = [kn.derive(chain(n)) for n in (1, 2)]
        ways = [{"contract": False}, {"cpu": "generic", "cache": False}, {}]
        expected = {
            (s, w): [getattr(eom.compile(**way), name)(0.0, X[:9, : 2 * (s + 1)]) for name in ("rhs", "mass_matrix")]
            for s, eom in enumerate(systems)
            for w, way in enumerate(ways)
        }
        calls = RHS(0.0, X)
        done = []

        def compile_and_drop(k):
            try:
                for w, way in enumerate(ways):
                    s = (k + w) % 2
                    compiled = systems[s].compile(**way)
                    found = [getattr(compiled, name)(0.0, X[:9, : 2 * (s + 1)]) for name in ("rhs", "mass_matrix")]
                    assert all(same(a, b) for a, b in zip(found, expected[s, w], strict=True))
            finally:
                done.append(k)

        def call(_):
            rounds = 0
            while rounds < 5 or len(done) < WORKERS // 2:
                assert same(RHS(0.0, X), calls)
                assert same(RHS(0.0, X[3]), calls[3])
                rounds += 1

        together(lambda k: (compile_and_drop if k % 2 else call)(k))

    def test_the_same_equations_at_once(self, tmp_path, monkeypatch):
        """All write one entry of the cache."""
        monkeypatch.setenv("KANE_CACHE", str(tmp_path / "objects"))
        eom = kn.derive(chain(2))
        found = together(lambda k: eom.compile().rhs(0.0, X[:, :4]))
        assert all(same(a, found[0]) for a in found)
        assert len(list((tmp_path / "objects").iterdir())) == 1

    def test_a_text_is_compiled_once(self, tmp_path, monkeypatch):
        """Threads that ask for the same text wait for the one that compiles it."""
        monkeypatch.setenv("KANE_CACHE", str(tmp_path / "objects"))
        own, compiled = machine.object_code, []

        def object_code(text, *more):
            compiled.append(text)
            time.sleep(0.05)  # the others ask meanwhile
            return own(text, *more)

        monkeypatch.setattr(machine, "object_code", object_code)
        texts = [f"define double @f() {{ ret double {k}.25 }}" for k in range(2)]

        def value(k):
            return machine.compile_text(texts[k % 2], machine.target(), ["f"]).function("f", ctypes.c_double)()

        assert together(value) == [k % 2 + 0.25 for k in range(WORKERS)]
        assert sorted(compiled) == texts

    def test_first_use_of_llvm_at_once(self):
        """Nothing has been set up yet: all threads find LLVM as it was loaded."""
        child("""
            import ctypes, threading
            from concurrent.futures import ThreadPoolExecutor
            from kane.program import machine

            barrier = threading.Barrier(8)

            def work(k):
                barrier.wait()
                text = f"define double @f() {{ ret double {k}.0 }}"
                return machine.compile_text(text, machine.target(), ["f"]).function("f", ctypes.c_double)

            with ThreadPoolExecutor(8) as pool:
                assert [f() for f in pool.map(work, range(8))] == list(range(8))
        """)

    def test_dropping_while_others_link(self):
        """Libraries die in other threads than those that made them, and by the collector in the middle of linking."""
        child("""
            import ctypes, gc, queue, threading
            from concurrent.futures import ThreadPoolExecutor
            from kane.program import machine

            gc.set_threshold(20, 2, 2)
            images = [machine.object_code(f"define double @f() {{ ret double {k}.0 }}", machine.target()) for k in range(4)]
            passed = queue.Queue(50)

            class Cycle:
                def __init__(self, held):
                    self.held, self.own = held, self

            def make(k):
                for i in range(80):
                    library = machine.Library(images[k], ["f"])
                    function = library.function("f", ctypes.c_double)
                    assert function() == k
                    passed.put((k, function))
                    if i % 3 == 0:
                        Cycle(library)
                passed.put(None)

            def drop(_):
                while (item := passed.get()) is not None:
                    assert item[1]() == item[0]

            with ThreadPoolExecutor(8) as pool:
                work = [pool.submit(make, k) for k in range(4)] + [pool.submit(drop, k) for k in range(4)]
                for future in work:
                    future.result()
        """)


class TestProcesses:
    def test_spawned_process_with_a_pickled_handle(self):
        with ProcessPoolExecutor(1, mp_context=multiprocessing.get_context("spawn")) as pool:
            found = pool.submit(RHS, 0.0, X, P[1]).result()
        assert same(found, RHS(0.0, X, P[1]))

    @pytest.mark.skipif(not hasattr(os, "fork"), reason="there is no fork here")
    def test_forked_process(self):
        """The child calls its parent's handle, compiles, links and drops."""
        child("""
            import gc, os, sys
            import numpy as np
            import kane as kn
            from kane.gallery.pendulums import system as chain

            eom = kn.derive(chain(2))
            handle = eom.compile().rhs
            x = np.array([0.1, 0.2, 0.3, 0.4])
            expected = handle(0.0, x).tobytes()
            pid = os.fork()
            assert handle(0.0, x).tobytes() == expected
            other = eom.compile(contract=False).rhs
            assert np.allclose(other(0.0, x), handle(0.0, x), rtol=1e-12)
            again = eom.compile().rhs
            del handle, other
            gc.collect()
            assert again(0.0, x).tobytes() == expected
            if pid:
                assert os.waitpid(pid, 0)[1] == 0
        """)

    @pytest.mark.skipif(not hasattr(os, "fork"), reason="there is no fork here")
    def test_fork_while_other_threads_compile(self):
        """The child has the threads' locks, but not the threads."""
        child(f"""{BUSY}
    import warnings
    warnings.simplefilter("ignore", DeprecationWarning)  # Python 3.12 and later warn of what is done here
    for k in range(4):
        pid = os.fork()
        if pid == 0:
            signal.alarm(20)
            machine.Library(machine.object_code(text, machine.target()), ["f1"])
            os._exit(0)
        assert os.waitpid(pid, 0)[1] == 0
        time.sleep(0.007)
        """)

    @pytest.mark.skipif(not hasattr(os, "fork"), reason="there is no fork here")
    def test_fork_while_another_thread_compiles_the_same(self, tmp_path):
        """The child does not wait for that thread, which it does not have."""
        child("""
            import ctypes, os, signal, threading, warnings
            from kane.program import machine

            warnings.simplefilter("ignore", DeprecationWarning)
            parent, own, begun, go_on = os.getpid(), machine.object_code, threading.Event(), threading.Event()

            def object_code(*arguments):
                if os.getpid() == parent:
                    begun.set()
                    go_on.wait()
                return own(*arguments)

            def value():
                text = "define double @f() { ret double 2.5 }"
                return machine.compile_text(text, machine.target(), ["f"]).function("f", ctypes.c_double)()

            machine.object_code = object_code
            thread = threading.Thread(target=value)
            thread.start()
            begun.wait()
            pid = os.fork()
            if pid == 0:
                signal.alarm(20)
                os._exit(value() != 2.5)
            assert os.waitpid(pid, 0)[1] == 0
            go_on.set()
            thread.join()
        """)


class TestExit:
    @pytest.mark.parametrize("delay", [0.0, 0.011])
    def test_while_daemon_threads_compile(self, delay):
        """LLVM's globals are destroyed at exit. What is registered to run at exit may still compile."""
        found = child(f"""
    import atexit, ctypes
    def last():
        library = machine.compile_text("define double @f() {{ ret double 5.0 }}", machine.target(), ["f"])
        print(library.function("f", ctypes.c_double)())
    atexit.register(last)
    {BUSY}
    time.sleep({delay})
        """)
        assert found == "5.0\n"

    def test_a_worker_that_is_joined_at_exit(self):
        """It registered first, so it is joined last: it must not wait for a lock that the end of LLVM holds."""
        found = child("""
            import atexit, queue, threading
            work, done = queue.Queue(), []

            def worker():
                while (task := work.get()) is not None:
                    try:
                        task()
                    except kn.ProgramError as error:
                        assert "interpreter" in str(error)
                    done.append(task)

            thread = threading.Thread(target=worker, daemon=True)
            thread.start()

            def join():
                work.put(None)
                thread.join()
                print(len(done))

            atexit.register(join)
            import kane as kn
            from kane.gallery.pendulums import system as chain

            eom = kn.derive(chain(2))
            eom.compile()
            for _ in range(5):
                work.put(eom.compile)
        """)
        assert found == "5\n"

    def test_while_daemon_threads_call(self):
        child("""
            import threading, time
            import numpy as np
            import kane as kn
            from kane.gallery.pendulums import system as chain

            handle = kn.derive(chain(3)).compile().rhs
            rows = np.full((20000, 6), 0.3)

            def forever(x):
                while True:
                    handle(0.0, x)

            for k in range(4):
                threading.Thread(target=forever, args=[rows if k % 2 else rows[0]], daemon=True).start()
            time.sleep(0.1)
        """)

    def test_with_handles_everywhere(self):
        """In modules, in cycles, in the attributes of functions: they go in any order."""
        child("""
            import ctypes, sys
            import kane as kn
            from kane.gallery.pendulums import system as chain

            class Last:
                def __init__(self, handle):
                    self.handle, self.own = handle, self

                def __del__(self):
                    self.handle(0.0, [0.1, 0.2])

            handle = kn.derive(chain(1)).compile().rhs
            sys.kept = handle
            ctypes.kept = Last(handle)
            kn.kept = [handle._call, handle._library]
            Last(handle)
        """)

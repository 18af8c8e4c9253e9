# SPDX-License-Identifier: BSD-3-Clause
"""The cache on disk: what is trusted, what is refused, how it stays small, and what other processes do to it."""

import hashlib
import json
import os
import shutil
import stat
import subprocess
import sys
import textwrap
import time
import warnings
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

import kane as kn
from kane.errors import KaneWarning
from kane.gallery.pendulums import system as chain
from kane.program import machine, store
from tests.program.child import child

KEY, ANOTHER = store.key("one"), store.key("another")
IMAGE = bytes(range(256)) * 40
X = np.array([0.1, 0.2, 0.3, 0.4])
posix = pytest.mark.skipif(not hasattr(os, "geteuid"), reason="no owners and modes here")


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A folder that does not exist yet."""
    place = tmp_path / "cache" / "objects"
    monkeypatch.setenv("KANE_CACHE", str(place))
    return place


def entry(folder, key=KEY):
    return folder / f"{key}.kaneobj"


def written(folder, key=KEY, image=IMAGE):
    store.write(key, image)
    assert entry(folder, key).is_file()
    return entry(folder, key)


def age(path, seconds):
    os.utime(path, (time.time() - seconds,) * 2)


class TestEntry:
    def test_what_was_written_is_read(self, folder):
        assert store.read(KEY) is None
        store.write(KEY, IMAGE)
        assert store.read(KEY) == IMAGE
        assert store.read(ANOTHER) is None

    @pytest.mark.parametrize("image", [b"", b"\n", b"\n\n{}\n", b"\x00" * 5, b"a\r\nb\r\n"])
    def test_any_bytes(self, folder, image):
        store.write(KEY, image)
        assert store.read(KEY) == image

    def test_header_and_digest(self, folder):
        """One line of JSON, then the object: nothing that is unpickled or run to be read."""
        head, _, rest = written(folder).read_bytes().partition(b"\n")
        found = json.loads(head)
        assert (found["key"], found["bytes"]) == (KEY, len(IMAGE))
        assert found["sha256"] == hashlib.sha256(IMAGE).hexdigest()
        assert rest == IMAGE

    def test_last_write_counts(self, folder):
        store.write(KEY, b"first")
        store.write(KEY, b"second")
        assert store.read(KEY) == b"second"
        assert len(list(folder.iterdir())) == 1

    def test_key_of_parts(self):
        """Where one part ends and the next begins matters."""
        assert len({store.key("ab", "c"), store.key("a", "bc"), store.key("abc"), store.key("ab", "c", "")}) == 4
        assert store.key("θ") == store.key("θ") != store.key("ϑ")
        assert len(store.key()) == 64

    @posix
    def test_modes(self, folder):
        path = written(folder)
        assert stat.S_IMODE(folder.stat().st_mode) == 0o700
        assert stat.S_IMODE(path.stat().st_mode) == 0o600

    @posix
    def test_modes_whatever_the_mask(self, folder):
        mask = os.umask(0)
        try:
            path = written(folder)
        finally:
            os.umask(mask)
        assert stat.S_IMODE(folder.stat().st_mode) == 0o700
        assert stat.S_IMODE(path.stat().st_mode) == 0o600


def cut_to(count):
    return lambda data: data[:count]


def changed(position, mask=1):
    def change(data):
        made = bytearray(data)
        made[position] ^= mask
        return bytes(made)

    return change


DAMAGES = {
    "empty": cut_to(0),
    "half a header": cut_to(30),
    "header alone": lambda data: data.partition(b"\n")[0],
    "header and line feed": lambda data: data.partition(b"\n")[0] + b"\n",
    "truncated": cut_to(-1),
    "one byte more": lambda data: data + b"\0",
    "last byte": changed(-1),
    "a bit in the middle": changed(-len(IMAGE) // 2, 0x80),
    "first byte of the header": changed(0),
    "object alone": lambda data: data.partition(b"\n")[2],
    "zeros": lambda data: bytes(len(data)),
    "another format": lambda data: data.replace(b"kane object 1", b"kane object 2"),
    "another digest": lambda data: data.replace(b'"sha256": "', b'"sha256": "0'),
    "a pickle": lambda data: b"cos\nsystem\n(S'exit 1'\ntR.",
}


class TestDamage:
    @pytest.mark.parametrize("damage", DAMAGES)
    def test_is_a_warning_and_is_replaced(self, folder, damage):
        path = written(folder)
        path.write_bytes(DAMAGES[damage](path.read_bytes()))
        with pytest.warns(KaneWarning, match="Expected an intact cache entry, got a damaged one: .*" + KEY):
            assert store.read(KEY) is None
        store.write(KEY, IMAGE)
        assert store.read(KEY) == IMAGE

    def test_valid_entry_under_another_key(self, folder):
        """Its digest is right, but it is the code of something else."""
        shutil.copy(written(folder), entry(folder, ANOTHER))
        with pytest.warns(KaneWarning, match="damaged"):
            assert store.read(ANOTHER) is None
        assert store.read(KEY) == IMAGE

    def test_folder_in_place_of_an_entry(self, folder):
        folder.mkdir(0o700, parents=True)
        entry(folder).mkdir()
        with pytest.warns(KaneWarning, match="Expected to read the cache entry .*Compiling anew"):
            assert store.read(KEY) is None
        with pytest.warns(KaneWarning, match="Expected to write to the cache folder .*Set KANE_CACHE"):
            store.write(KEY, IMAGE)
        store.write(ANOTHER, IMAGE)
        assert sorted(folder.iterdir()) == sorted([entry(folder), entry(folder, ANOTHER)]), (
            "nothing half-written is left"
        )
        assert store.size()[0] == 1
        assert store.clear()[0] == 1

    def test_compiling_goes_on(self, folder, monkeypatch):
        """The whole way: damage, warning, compilation, the right numbers, an intact entry."""
        eom = kn.derive(chain(2))
        expected = eom.compile().rhs(0.0, X)
        (path,) = folder.iterdir()
        path.write_bytes(path.read_bytes()[:-9])
        with pytest.warns(KaneWarning, match="damaged"):
            assert np.array_equal(eom.compile().rhs(0.0, X), expected)
        monkeypatch.setattr(machine, "object_code", None)
        assert np.array_equal(eom.compile().rhs(0.0, X), expected)


class TestTrust:
    def refused(self, what):
        """Neither read nor written, with a warning each; equations compile all the same."""
        with pytest.warns(KaneWarning, match=what) as found:
            assert store.read(KEY) is None
        assert str(found[0].message).endswith(
            ("Set KANE_CACHE to a folder of your own, or to off.", "anew and replacing it.")
        )
        with pytest.warns(KaneWarning, match=what):
            compiled = kn.derive(chain(2)).compile()
        assert np.isfinite(compiled.rhs(0.0, X)).all()

    @posix
    @pytest.mark.parametrize("mode", [0o777, 0o770, 0o720, 0o702, 0o1777])
    def test_folder_that_others_can_write(self, folder, mode):
        written(folder)
        folder.chmod(mode)
        self.refused(rf"belongs to this user and that nobody else can write to, got .*mode {mode:o}\): it is not used")
        assert len(list(folder.iterdir())) == 1
        folder.chmod(0o755)
        assert store.read(KEY) == IMAGE, "others may read"

    @posix
    def test_folder_of_another_user(self, folder, monkeypatch):
        written(folder)
        me = os.geteuid()
        monkeypatch.setattr(os, "geteuid", lambda: me + 1)
        self.refused(rf"belongs to this user .*owner {folder.stat().st_uid}, mode 700\)")

    @posix
    def test_effective_user_counts(self, folder, monkeypatch):
        """A program that runs for another user than the one who called it does not trust the caller's folder."""
        written(folder)
        me = os.getuid()
        monkeypatch.setattr(os, "getuid", lambda: me + 1)
        assert store.read(KEY) == IMAGE

    @posix
    def test_entry_that_others_can_write(self, folder):
        path = written(folder)
        path.chmod(0o622)
        with pytest.warns(KaneWarning, match=r"Expected a cache entry that belongs .*mode 622\)\. Compiling anew"):
            assert store.read(KEY) is None
        store.write(KEY, IMAGE)
        assert store.read(KEY) == IMAGE

    @posix
    def test_folder_that_is_swapped_after_the_check(self, folder, monkeypatch):
        """Between the check of the folder and the reading of a file another user put his own folder there."""
        path = written(folder)
        me = os.geteuid()
        monkeypatch.setattr(store, "_trusted", lambda make: folder)
        monkeypatch.setattr(os, "geteuid", lambda: me + 1)
        with pytest.warns(KaneWarning, match=f"Expected a cache entry that belongs to this user .*{path.name}"):
            assert store.read(KEY) is None

    @posix
    def test_link_to_a_folder_of_one_s_own(self, folder, tmp_path):
        (tmp_path / "elsewhere").mkdir(mode=0o700)
        folder.parent.mkdir()
        folder.symlink_to(tmp_path / "elsewhere")
        assert written(folder).resolve().parent == tmp_path / "elsewhere"
        assert store.read(KEY) == IMAGE

    @posix
    def test_link_to_a_folder_that_others_can_write(self, folder, tmp_path):
        (tmp_path / "elsewhere").mkdir()
        (tmp_path / "elsewhere").chmod(0o777)
        folder.parent.mkdir()
        folder.symlink_to(tmp_path / "elsewhere")
        self.refused("nobody else can write to")
        assert list((tmp_path / "elsewhere").iterdir()) == []

    @posix
    def test_link_to_nowhere(self, folder):
        folder.parent.mkdir()
        folder.symlink_to("nowhere")
        assert store.read(KEY) is None
        with pytest.warns(KaneWarning, match="Expected to use the cache folder"):
            store.write(KEY, IMAGE)

    def test_file_in_place_of_the_folder(self, folder):
        folder.parent.mkdir()
        folder.write_text("something else")
        self.refused("Expected (a folder for the cache|to use the cache folder)")
        assert folder.read_text() == "something else"
        assert store.size() == store.clear() == (0, 0)

    def test_file_above_the_folder(self, folder):
        folder.parent.write_text("something else")
        with pytest.warns(KaneWarning, match="Expected to use the cache folder .*Set KANE_CACHE"):
            store.write(KEY, IMAGE)
        assert store.size() == store.clear() == (0, 0)


class TestUnwritable:
    @pytest.mark.skipif(sys.platform != "linux", reason="nobody can make folders in /proc")
    def test_folder_that_cannot_be_made(self, monkeypatch):
        monkeypatch.setenv("KANE_CACHE", "/proc/kane/objects")
        assert store.read(KEY) is None
        with pytest.warns(
            KaneWarning, match="Expected to use the cache folder /proc/kane/objects, got .*Set KANE_CACHE"
        ):
            store.write(KEY, IMAGE)

    @pytest.mark.parametrize("function", ["replace", "fdopen", "unlink"])
    def test_disk_that_refuses(self, folder, monkeypatch, function):
        """Full, read-only or gone: what was half written is removed, and compiling goes on."""
        folder.mkdir(mode=0o700, parents=True)

        def refuse(*_, **__):
            raise OSError(28, "No space left on device")

        with monkeypatch.context() as broken:
            broken.setattr(os, "replace", refuse)
            if function != "replace":
                broken.setattr(os, function, refuse)
            with pytest.warns(KaneWarning, match=f"Expected to write to the cache folder {folder}, got No space left"):
                compiled = kn.derive(chain(2)).compile()
        assert np.isfinite(compiled.rhs(0.0, X)).all()
        assert len(list(folder.iterdir())) == (function == "unlink")
        assert store.size() == (0, 0)

    def test_read_only_entry_is_used(self, folder, monkeypatch):
        """That its time of use cannot be written is no reason to compile."""
        written(folder)

        def refuse(*_, **__):
            raise PermissionError(13, "Permission denied")

        monkeypatch.setattr(os, "utime", refuse)
        assert store.read(KEY) == IMAGE

    @posix
    def test_pipe_in_place_of_an_entry(self, folder):
        """It would be waited for until somebody writes into it."""
        written(folder)
        entry(folder).unlink()
        os.mkfifo(entry(folder), 0o600)
        with pytest.warns(KaneWarning, match="Expected a file as cache entry, got something else at"):
            assert store.read(KEY) is None
        store.write(KEY, IMAGE)
        assert store.read(KEY) == IMAGE

    @posix
    def test_unreadable_entry(self, folder, monkeypatch):
        path = written(folder)

        def refuse(*_, **__):
            raise PermissionError(13, "Permission denied")

        monkeypatch.setattr(os, "open", refuse)
        with pytest.warns(KaneWarning, match=f"Expected to read the cache entry {path}, got Permission denied"):
            assert store.read(KEY) is None

    def test_entry_that_cannot_be_removed(self, folder, monkeypatch):
        written(folder)

        def refuse(*_, **__):
            raise PermissionError(13, "Permission denied")

        monkeypatch.setattr(Path, "unlink", refuse)
        with pytest.warns(KaneWarning, match="Expected to remove the cache entry .*got Permission denied"):
            assert store.clear() == (0, 0)

    @pytest.mark.slow
    @posix
    def test_as_another_user(self, folder):
        """Modes do not stop the superuser, so what they stop is tried by somebody else."""
        if os.geteuid() != 0:
            folder.mkdir(mode=0o500, parents=True)
            with pytest.warns(KaneWarning, match="got Permission denied"):
                store.write(KEY, IMAGE)
            return
        written(folder)
        folder.chmod(0o755)
        child(
            """
            import os, warnings
            from kane.program.native import store
            import tempfile

            warnings.simplefilter("always")
            os.setgroups([]), os.setgid(65534), os.setuid(65534)
            def told(act, *given):
                with warnings.catch_warnings(record=True) as found:
                    assert act(*given) is None
                return [str(w.message) for w in found]

            key = store.key("one")
            for messages in (told(store.read, key), told(store.write, key, b"mine")):
                assert len(messages) == 1, messages
                assert "Permission denied" in messages[0] or "belongs to this user" in messages[0], messages
        """,
            folder,
        )
        assert store.read(KEY) == IMAGE


class TestWhere:
    @pytest.mark.parametrize("off", ["off", "OFF", "Off", "0", "no"])
    def test_off(self, monkeypatch, tmp_path, off):
        monkeypatch.chdir(tmp_path)
        monkeypatch.setenv("KANE_CACHE", off)
        assert store.folder() is None
        store.write(KEY, IMAGE)
        assert store.read(KEY) is None
        assert store.size() == store.clear() == (0, 0)
        assert list(tmp_path.iterdir()) == []

    @pytest.mark.parametrize("value", [None, ""])
    def test_user_s_cache_folder(self, monkeypatch, value):
        from platformdirs import user_cache_path

        monkeypatch.delenv("KANE_CACHE") if value is None else monkeypatch.setenv("KANE_CACHE", value)
        assert store.folder() == user_cache_path("kane", appauthor=False) / "objects"

    def test_tilde(self, monkeypatch, tmp_path):
        monkeypatch.setenv("HOME", str(tmp_path))
        monkeypatch.setenv("USERPROFILE", str(tmp_path))
        monkeypatch.setenv("KANE_CACHE", os.path.join("~", "mine"))
        assert store.folder() == tmp_path / "mine"

    @pytest.mark.skipif(sys.platform != "linux", reason="other systems ask elsewhere")
    def test_no_home(self, monkeypatch, tmp_path):
        """Neither HOME nor an entry of the user in the system's table: nothing is written where the process happens to be."""
        import pwd

        def missing(_):
            raise KeyError

        for name in ("KANE_CACHE", "HOME", "XDG_CACHE_HOME"):
            monkeypatch.delenv(name, raising=False)
        monkeypatch.setattr(pwd, "getpwuid", missing)
        monkeypatch.chdir(tmp_path)
        with pytest.warns(KaneWarning, match="Expected a home folder of this user .*nothing is cached. Set KANE_CACHE"):
            store.write(KEY, IMAGE)
        with pytest.warns(KaneWarning, match="home folder"):
            assert store.read(KEY) is None
        assert list(tmp_path.iterdir()) == []

    @pytest.mark.parametrize("version", [None, "~/.cache/kane"])
    def test_home_is_relative_or_unknown(self, monkeypatch, version):
        """Versions of platformdirs raise, or give a relative path."""
        import platformdirs

        def found(*_, **__):
            if version is None:
                raise RuntimeError("could not determine the home directory")
            return Path(version)

        monkeypatch.delenv("KANE_CACHE")
        monkeypatch.setattr(platformdirs, "user_cache_path", found)
        with pytest.warns(KaneWarning, match="home folder"):
            assert store.folder() is None

    @pytest.mark.skipif(sys.platform != "linux", reason="other systems ask elsewhere")
    def test_home_unset(self, monkeypatch):
        """The system's table has it."""
        monkeypatch.delenv("KANE_CACHE")
        monkeypatch.delenv("XDG_CACHE_HOME", raising=False)
        monkeypatch.delenv("HOME", raising=False)
        assert store.folder() == Path(os.path.expanduser("~")) / ".cache" / "kane" / "objects"

    def test_reading_makes_no_folder(self, folder):
        assert store.read(KEY) is None
        assert store.size() == store.clear() == (0, 0)
        assert not folder.parent.exists()


class TestSize:
    def filled(self, folder, count=5):
        """Entries of 1000 bytes and more, the first used longest ago."""
        keys = [store.key(str(k)) for k in range(count)]
        for k, key in enumerate(keys):
            age(written(folder, key, bytes(1000)), 1000 - k)
        return keys

    def left(self, folder, keys):
        return [k for k, key in enumerate(keys) if entry(folder, key).exists()]

    def test_least_recently_used_go(self, folder, monkeypatch):
        keys = self.filled(folder)
        monkeypatch.setattr(store, "LIMIT", round(4.5 * entry(folder, keys[0]).stat().st_size))
        store.write(KEY, bytes(1000))
        assert self.left(folder, keys) == [2, 3, 4]
        assert store.read(KEY) is not None
        assert store.size()[1] <= store.LIMIT

    def test_reading_is_use(self, folder, monkeypatch):
        keys = self.filled(folder)
        assert store.read(keys[0]) is not None
        monkeypatch.setattr(store, "LIMIT", round(3.5 * entry(folder, keys[0]).stat().st_size))
        store.write(KEY, bytes(1000))
        assert self.left(folder, keys) == [0, 4]

    def test_within_the_limit_nothing_goes(self, folder, monkeypatch):
        keys = self.filled(folder)
        monkeypatch.setattr(store, "LIMIT", 6 * entry(folder, keys[0]).stat().st_size)
        store.write(KEY, bytes(1000))
        assert self.left(folder, keys) == [0, 1, 2, 3, 4]

    def test_nothing_exceeds_the_limit(self, folder, monkeypatch):
        monkeypatch.setattr(store, "LIMIT", 500)
        store.write(KEY, bytes(1000))
        assert store.size() == (0, 0)

    def test_most_writes_look_at_no_other_entry(self, folder, monkeypatch):
        """Nor where the folder is full: entries go many at once."""
        looks, scandir = [], os.scandir
        monkeypatch.setattr(store, "LIMIT", 320_000)
        monkeypatch.setattr(os, "scandir", lambda place: looks.append(place) or scandir(place))
        for k in range(400):
            store.write(store.key(str(k)), bytes(1000))
        assert len(looks) <= 250  # twice for each 64th of the limit
        assert 0.85 * store.LIMIT < store.size()[1] <= store.LIMIT

    def test_limit(self):
        assert store.LIMIT == 256 * 2**20

    def test_size_and_clear(self, folder):
        keys = self.filled(folder)
        (folder / "notes.txt").write_text("not the cache's")
        total = sum(entry(folder, key).stat().st_size for key in keys)
        assert store.size() == (5, total)
        assert store.clear() == (5, total)
        assert store.clear() == store.size() == (0, 0)
        assert [path.name for path in folder.iterdir()] == ["notes.txt"]
        assert store.read(keys[0]) is None

    @pytest.mark.parametrize("act", [lambda: store.write(KEY, IMAGE), store.clear])
    def test_half_written_entries_of_dead_processes_go(self, folder, act):
        """Those of live ones stay, which are about to be renamed, and what is not the cache's."""
        folder.mkdir(mode=0o700, parents=True)
        for name, seconds in (("dead.kaneobj.part", 7200), ("alive.kaneobj.part", 5), ("film.mp4.part", 7200)):
            (folder / name).write_bytes(b"half")
            age(folder / name, seconds)
        act()
        assert {path.name for path in folder.glob("*.part")} == {"alive.kaneobj.part", "film.mp4.part"}

    def test_removed_by_another_process_meanwhile(self, folder, monkeypatch):
        keys = self.filled(folder)
        monkeypatch.setattr(store, "LIMIT", 0)
        unlink = Path.unlink

        def twice(path, missing_ok=False):
            unlink(path)
            unlink(path, missing_ok=missing_ok)

        monkeypatch.setattr(Path, "unlink", twice)
        store.write(KEY, IMAGE)
        assert self.left(folder, keys) == []


@pytest.mark.slow
class TestAtTheSameTime:
    def test_threads_read_write_and_clear(self, folder):
        """Whoever reads gets one writer's bytes as a whole, or nothing; no warning, no half-written file."""
        images = [bytes([k]) * 50_000 for k in range(4)]

        def write(k):
            for _ in range(40):
                store.write(KEY, images[k])

        def read(_):
            return [store.read(KEY) for _ in range(150)]

        def clear(_):
            for _ in range(20):
                store.clear()

        with warnings.catch_warnings():
            warnings.simplefilter("error")
            with ThreadPoolExecutor(8) as pool:
                futures = [pool.submit(write, k) for k in range(4)] + [pool.submit(clear, 0)]
                reads = [pool.submit(read, k) for k in range(3)]
                for future in futures:
                    future.result()
                found = [image for future in reads for image in future.result()]
        assert set(found) <= {None, *images}
        assert any(found)
        assert list(folder.glob("*.part")) == []

    def test_processes_write_one_entry(self, folder):
        code = """
            import sys
            from kane.program.native import store
            key, image = store.key("one"), bytes([int(sys.argv[1])]) * 200_000
            print("ready", flush=True)
            sys.stdin.readline()
            for _ in range(60):
                store.write(key, image)
                found = store.read(key)
                assert found is not None and len(found) == 200_000 and len(set(found)) == 1
        """
        run = [sys.executable, "-W", "error", "-c", textwrap.dedent(code)]
        children = [
            subprocess.Popen([*run, str(k)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
            for k in range(2)
        ]
        for one in children:
            assert one.stdout.readline().strip() == b"ready"
        for one in children:
            one.stdin.write(b"\n")
            one.stdin.flush()
        for one in children:
            _, errors = one.communicate(timeout=60)
            assert one.returncode == 0, errors.decode()
        assert [path.name for path in folder.iterdir()] == [entry(folder).name]
        assert store.read(KEY) is not None

    def test_entry_replaced_while_it_is_read(self, folder, monkeypatch):
        """The reader has the old file open: it gets the old bytes, all of them."""
        written(folder)
        fstat = os.fstat

        def replace_then_stat(number):
            monkeypatch.setattr(os, "fstat", fstat)
            store.write(KEY, b"new")
            return fstat(number)

        monkeypatch.setattr(os, "fstat", replace_then_stat)
        assert store.read(KEY) == IMAGE
        assert store.read(KEY) == b"new"

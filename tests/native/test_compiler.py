"""Compilers that are missing, fail or hang; compiled code that others could have written, or that is spoilt."""

import os
import stat
import subprocess
import sys
from pathlib import Path

import pytest

from artipg_dsl.errors import UserError
from artipg_dsl.native import backend, compiler

from .machine import needs_compiler

pytestmark = pytest.mark.usefixtures("nothing_kept")


@pytest.fixture
def home(nothing_kept, tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.delenv("APGC_CACHE")
    return tmp_path / "artipg_dsl" / "compiled"


def program(path: Path, text: str) -> Path:
    path.write_text("#!/bin/sh\n" + text)
    path.chmod(0o755)
    return path


@pytest.fixture
def only(tmp_path, monkeypatch):
    """A compiler that is the only one there: what a shell script does."""

    def make(text: str) -> None:
        monkeypatch.setattr(compiler, "compilers", lambda: [[str(program(tmp_path / "cc", text))]])

    return make


@pytest.fixture
def short(tmp_path, monkeypatch):
    """A machine that is compiled at once. What is kept, and trusted, is asked before it is loaded."""
    source = tmp_path / "short.c"
    source.write_text("int run(void) { return 0; }\n")
    monkeypatch.setattr(compiler, "_SOURCES", [source])


@needs_compiler
def test_what_was_compiled_is_found_again(home, short):
    assert compiler.kept() is None
    made = compiler.compile_machine()
    assert made.parent == home and compiler.kept() == made
    assert not list(home.glob("*.partial"))
    if os.name == "posix":
        assert stat.S_IMODE(home.stat().st_mode) == 0o700 and stat.S_IMODE(made.stat().st_mode) == 0o600


@needs_compiler
def test_spoilt_code_is_never_loaded(home, short):
    made = compiler.compile_machine()
    made.write_bytes(made.read_bytes()[:-1])
    assert compiler.kept() is None


@needs_compiler
@pytest.mark.skipif(os.name != "posix", reason="Windows keeps the folders of users apart")
def test_code_that_others_could_have_written_is_never_loaded(home, short):
    made = compiler.compile_machine()
    made.chmod(0o622)
    assert compiler.kept() is None
    made.chmod(0o600)
    home.chmod(0o777)
    assert compiler.kept() is None
    home.chmod(0o700)
    assert compiler.kept() == made


@needs_compiler
def test_a_link_is_not_followed(home, short, tmp_path):
    made = compiler.compile_machine()
    moved = made.rename(tmp_path / "elsewhere")
    made.symlink_to(moved)
    assert compiler.kept() is None


@needs_compiler
def test_a_machine_is_kept_for_its_user_whatever_folder_is_shared(home, short, tmp_path, monkeypatch):
    monkeypatch.setenv("APGC_CACHE", str(tmp_path / "shared"))
    assert compiler.compile_machine().parent == home


def test_nothing_is_compiled_where_nothing_is_kept(choosing):
    choosing(None)
    assert backend.machine() is None and "nothing is kept" in backend.told()


@pytest.mark.parametrize(
    "text, said",
    [
        ("echo 'no such header' >&2; exit 1", "failed: no such header"),
        ("sleep 20", "was not done after"),
        ("exit 0", "cannot be loaded"),
    ],
)
def test_a_compiler_that_does_not_work_is_named(text, said, only, choosing, monkeypatch):
    only(text)
    monkeypatch.setattr(compiler, "SECONDS", 0.5)
    with pytest.raises(UserError, match="there is no backend c") as wrong:
        choosing("c")
    assert said in wrong.value.message


@pytest.mark.parametrize("text", [None, "exit 1", "exit 0"])
def test_no_folder_is_left_where_nothing_can_be_kept(text, only, choosing, tmp_path, monkeypatch):
    monkeypatch.setattr(compiler, "folder", lambda: None)
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path / "passing"))
    (tmp_path / "passing").mkdir()
    if text is None:
        monkeypatch.setattr(compiler, "compilers", lambda: [])
    else:
        only(text)
    with pytest.raises(UserError, match="there is no backend c"):
        choosing("c")
    assert not list((tmp_path / "passing").iterdir())


@needs_compiler
def test_no_folder_is_left_by_a_run_that_is_sooner_than_the_compiler(tmp_path):
    """Where the user's own folder cannot be written: here a file is in its place."""
    (tmp_path / "artipg_dsl").write_text("")
    (tmp_path / "passing").mkdir()
    places = {
        "XDG_CACHE_HOME": str(tmp_path),
        "APGC_CACHE": str(tmp_path / "kept"),
        "TMPDIR": str(tmp_path / "passing"),
    }
    code = "from artipg_dsl.native import backend; backend.machine(); backend._state.beside.join(0.02)"
    subprocess.run([sys.executable, "-c", code], env=os.environ | places, check=True)
    assert not list((tmp_path / "passing").glob("apgc-*"))  # those of the compiler go with it


def test_a_folder_that_cannot_be_written_is_told(choosing, tmp_path, monkeypatch):
    monkeypatch.setattr(compiler, "folder", lambda: None)
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path / "absent"))
    monkeypatch.setattr(compiler, "compilers", lambda: [["cc"]])
    with pytest.raises(UserError, match="there is no folder to compile in"):
        choosing("c")


def test_no_compiler_is_an_error_only_where_it_is_asked_for(home, choosing, monkeypatch):
    monkeypatch.setattr(compiler, "compilers", lambda: [])
    with pytest.raises(UserError, match="there is no C compiler"):
        choosing("c")
    choosing(None)
    backend._state.beside.join()
    assert backend.machine() is None and "there is no C compiler" in backend.told()


@needs_compiler
def test_numpy_works_until_the_compiler_is_done(home, choosing):
    choosing(None)
    backend._state.beside.join()
    assert backend.told() == "c"
    choosing("numpy")
    assert backend.machine() is None and backend.told() == "numpy (as asked)"


def test_a_backend_that_does_not_exist_is_refused(choosing):
    with pytest.raises(UserError, match="names no backend: `cuda`"):
        choosing("cuda")


@needs_compiler
def test_a_file_of_something_else_is_no_machine(tmp_path):
    other = tmp_path / "other.c"
    other.write_text("int run(void) { return 0; }\n")
    command = compiler.compilers()[0]
    made = tmp_path / "other.so"
    assert os.spawnvp(os.P_WAIT, command[0], [*command, "-shared", "-fPIC", str(other), "-o", str(made)]) == 0
    with pytest.raises(compiler.NoMachine, match="not whole"):
        backend.Machine(compiler.load(made))

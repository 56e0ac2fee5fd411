"""Files and folders appear whole or not at all."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from artipg_dsl.export.write import (
    ExportError,
    ensure_folder,
    replacing_file,
    replacing_folder,
    require_place,
    sweep_unfinished,
    write_bytes,
)


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


def test_a_file_is_refused_where_one_exists_unless_forced(tmp_path: Path) -> None:
    target = tmp_path / "deep" / "a.bin"
    write_bytes(target, b"one")
    with pytest.raises(ExportError) as caught:
        write_bytes(target, b"two")
    assert "exists" in caught.value.message and "--force" in caught.value.hint
    assert target.read_bytes() == b"one"
    write_bytes(target, b"two", force=True)
    assert target.read_bytes() == b"two" and names(target.parent) == ["a.bin"]


@pytest.mark.parametrize("error", [KeyboardInterrupt, ValueError])
def test_an_interrupted_file_leaves_nothing(tmp_path: Path, error: type[BaseException]) -> None:
    with pytest.raises(error), replacing_file(tmp_path / "a.bin") as stream:
        stream.write(b"half")
        raise error
    assert names(tmp_path) == []


def test_an_interrupted_folder_leaves_the_old_one(tmp_path: Path) -> None:
    with replacing_folder(tmp_path / "o") as folder:
        (folder / "x").write_bytes(b"old")
    with pytest.raises(KeyboardInterrupt), replacing_folder(tmp_path / "o", force=True) as folder:
        (folder / "x").write_bytes(b"new")
        raise KeyboardInterrupt
    assert names(tmp_path) == ["o"] and (tmp_path / "o" / "x").read_bytes() == b"old"
    with replacing_folder(tmp_path / "o", force=True) as folder:
        (folder / "y").write_bytes(b"new")
    assert names(tmp_path) == ["o"] and names(tmp_path / "o") == ["y"]


def test_a_link_to_nothing_is_named(tmp_path: Path) -> None:
    (tmp_path / "out").symlink_to(tmp_path / "gone")
    with pytest.raises(ExportError, match="out is a link to .*gone, which is not there"):
        ensure_folder(tmp_path / "out")


def test_a_file_in_the_way_of_a_folder_is_named(tmp_path: Path) -> None:
    (tmp_path / "file").write_bytes(b"")
    with pytest.raises(ExportError) as caught:
        write_bytes(tmp_path / "file" / "a.bin", b"")
    assert "in the way" in caught.value.message and "file" in caught.value.message
    (tmp_path / "folder").mkdir()
    with pytest.raises(ExportError) as caught:
        write_bytes(tmp_path / "folder", b"", force=True)
    assert "is a folder" in caught.value.message


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write anywhere")
def test_a_folder_without_permission_is_named(tmp_path: Path) -> None:
    (tmp_path / "closed").mkdir(mode=0o555)
    with pytest.raises(ExportError) as caught:
        write_bytes(tmp_path / "closed" / "a.bin", b"")
    assert "no permission" in caught.value.message and "partial" not in caught.value.message


def test_a_place_that_takes_no_file_is_told_before_the_work(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "file").write_bytes(b"x")
    for place, words in (("file", "exists"), ("file/deep/a.png", "file is in the way"), (".", "is a folder")):
        with pytest.raises(ExportError) as caught:
            require_place(tmp_path / place, force=place == ".")
        assert words in caught.value.message
    require_place(tmp_path / "new" / "deep" / "a.png", force=False)
    require_place(Path("/dev/null"), force=False)
    monkeypatch.setattr(os, "access", lambda place, mode: place != tmp_path.resolve())
    with pytest.raises(ExportError) as caught:
        require_place(tmp_path / "new" / "a.png", force=False)
    assert "no permission" in caught.value.message and names(tmp_path) == ["file"]


def test_permission_and_space_are_told_in_words(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for code, words in ((13, "no permission"), (28, "no space left"), (36, "too long")):

        def refuse(source: object, target: object, code: int = code) -> None:
            raise OSError(code, "refused", str(source))

        monkeypatch.setattr(os, "replace", refuse)
        with pytest.raises(ExportError) as caught:
            write_bytes(tmp_path / "a.bin", b"x")
        assert words in caught.value.message and "partial" not in caught.value.message
        assert names(tmp_path) == []


def test_what_a_killed_process_left_is_swept(tmp_path: Path) -> None:
    dead = next(n for n in range(4_000_000, 4_100_000) if not Path(f"/proc/{n}").exists())
    (tmp_path / f".a.bin.partial-{dead}").write_bytes(b"half")
    (tmp_path / f".o.partial-{dead}").mkdir()
    (tmp_path / f".b.bin.partial-{os.getpid()}").write_bytes(b"still at it")
    (tmp_path / ".hidden").write_bytes(b"")
    sweep_unfinished(tmp_path)
    assert names(tmp_path) == [f".b.bin.partial-{os.getpid()}", ".hidden"]


def test_a_command_that_writes_one_file_sweeps_what_was_left_of_it(tmp_path: Path) -> None:
    dead = next(n for n in range(4_000_000, 4_100_000) if not Path(f"/proc/{n}").exists())
    mine, other = tmp_path / f".a[1].png.partial-{dead}", tmp_path / f".a1.png.partial-{dead}"
    for left in (mine, other):
        left.write_bytes(b"half")
    require_place(tmp_path / "a[1].png", force=False)
    assert not mine.exists() and other.exists()


def test_a_folder_that_a_killed_process_had_put_aside_comes_back(tmp_path: Path) -> None:
    """It was killed after the old folder had gone out of the way, and before the new one had its name."""
    code = """if True:
        import os, sys
        from artipg_dsl.export import write
        name = os.rename
        write.os.rename = lambda old, new: name(old, new) if str(new).endswith("-old") else os._exit(9)
        with write.replacing_folder(sys.argv[1], force=True) as made:
            (made / "new").write_text("2")
    """
    (tmp_path / "000000").mkdir()
    (tmp_path / "000000" / "mine").write_text("1")
    assert subprocess.run([sys.executable, "-c", code, str(tmp_path / "000000")], check=False).returncode == 9
    assert "000000" not in names(tmp_path) and len(names(tmp_path)) == 2
    sweep_unfinished(tmp_path)
    assert names(tmp_path) == ["000000"] and names(tmp_path / "000000") == ["mine"]


def test_no_process_is_sent_a_signal_where_there_is_none_that_only_asks(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """On Windows, signal 0 is Ctrl-C."""
    monkeypatch.delattr(signal, "SIGHUP")
    monkeypatch.setattr(os, "kill", lambda *sent: pytest.fail(f"sent {sent}"))
    (tmp_path / ".a.bin.partial-4000000").write_bytes(b"half")
    sweep_unfinished(tmp_path)
    assert names(tmp_path) == [".a.bin.partial-4000000"]


@pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="only Linux says whether a process has ended")
def test_what_a_process_left_that_nobody_has_waited_for_is_swept(tmp_path: Path) -> None:
    """In containers without an init, those that were killed are listed for ever."""
    with subprocess.Popen([sys.executable, "-c", ""]) as ended:
        while Path(f"/proc/{ended.pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z":
            time.sleep(0.01)
        (tmp_path / f".a.bin.partial-{ended.pid}").write_bytes(b"half")
        sweep_unfinished(tmp_path)
        assert names(tmp_path) == []


def test_what_is_written_can_be_read_meanwhile(tmp_path: Path) -> None:
    """As HDF5 does with large files."""
    with replacing_file(tmp_path / "file") as stream:
        stream.write(b"first")
        stream.seek(1)
        assert stream.read(3) == b"irs"
    assert (tmp_path / "file").read_bytes() == b"first"

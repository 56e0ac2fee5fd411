"""Folders of fsspec: the same bytes as here, whole or not at all, gone on with after an interruption."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from artipg_dsl.annotate.sampling import Sampling
from artipg_dsl.cli.main import main
from artipg_dsl.errors import UsageError, UserError
from artipg_dsl.export.content import Content
from artipg_dsl.export.remote import Remote, is_same, place_of
from artipg_dsl.export.write import ExportError, write_bytes
from artipg_dsl.run.dataset import write_dataset
from artipg_dsl.run.job import open_job
from artipg_dsl.run.output import Output
from artipg_dsl.run.request import read_request
from artipg_dsl.run.resume import reopen
from artipg_dsl.run.sharing import Workers

fsspec = pytest.importorskip("fsspec")
OUTPUT = Output(("points", "tables", "annotation", "urdf"), Content(Sampling(16)), 4)


@pytest.fixture
def store() -> Iterator[dict[str, Any]]:
    """What lies in memory, by path."""
    found = fsspec.filesystem("memory").store
    found.clear()
    yield found
    found.clear()


def files(store: dict[str, Any], folder: str) -> dict[str, bytes]:
    return {n.removeprefix(f"/{folder}/"): f.getvalue() for n, f in store.items() if n.startswith(f"/{folder}/")}


def tree(folder: Path) -> dict[str, bytes]:
    return {str(p.relative_to(folder)): p.read_bytes() for p in sorted(folder.rglob("*")) if p.is_file()}


def test_the_same_bytes_as_in_a_folder(tmp_path: Path, store: dict[str, Any]) -> None:
    asked = open_job(read_request("Globe", n=6, checked=False))
    write_dataset(asked.fresh(), tmp_path / "o", OUTPUT)
    plain, at = Remote.write_bytes, iter(range(10**6))

    def failing(self: Remote, data: bytes) -> None:
        if next(at) == 30:
            raise OSError("the line is cut")
        plain(self, data)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Remote, "write_bytes", failing)
        with pytest.raises(ExportError, match="cannot write memory://o/.*the line is cut"):
            write_dataset(asked.fresh(), "memory://o", OUTPUT)
    assert 0 < len(files(store, "o")) < len(tree(tmp_path / "o"))
    write_dataset(asked.fresh(), "memory://o", OUTPUT)
    assert files(store, "o") == tree(tmp_path / "o")
    before = dict(store)
    write_dataset(asked.fresh(), "memory://o", OUTPUT)
    assert {n: id(f) for n, f in store.items()} == {n: id(f) for n, f in before.items()}  # nothing is written again
    assert reopen("memory://o").tables is not None and len(reopen("memory://o").batch([1, 5])) == 2
    with pytest.raises(ExportError, match="other options"):
        write_dataset(asked.fresh(), "memory://o", Output(("annotation",)))
    write_dataset(asked.fresh(), "memory://o", Output(("annotation",)), force=True)
    assert set(files(store, "o")) == {"annotation-00000.jsonl", "manifest.json"}


def test_by_the_command_line(tmp_path: Path, store: dict[str, Any], capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["sample", "Globe", "-n", "2", "--unchecked", "--tables", "-o", "memory://t"]) == 0
    assert set(files(store, "t")) == {"manifest.json", "tables-00000.npz"}
    assert main(["sample", "memory://t", "--points", "8", "-o", f"file://{tmp_path}/p"]) == 0
    assert (tmp_path / "p/points-00000.npz").is_file()
    assert main(["export", "memory://t", "--format", "obj"]) == 0
    assert "objects/000001/obj/object.mtl" in files(store, "t")
    assert main(["sample", "Globe", "-o", "memory://w", "--workers", "2"]) == 2
    assert "seen by one process alone" in capsys.readouterr().err
    assert main(["sample", "Globe", "-o", "nosuch://w"]) == 1
    assert "cannot reach nosuch://w" in capsys.readouterr().err


def test_elsewhere_files_are_moved_into_place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A file system that is none of the stores: its files appear by a move."""
    local = fsspec.filesystem("file")
    monkeypatch.setattr(Remote, "_place", property(lambda self: (local, str(tmp_path / self.address.split("//")[1]))))
    moved = []
    monkeypatch.setattr(type(local), "mv", lambda self, a, b: (moved.append((a, b)), Path(a).rename(b)))
    write_bytes(place_of("sftp://host/a"), b"whole")
    assert (tmp_path / "host/a").read_bytes() == b"whole" and len(moved) == 1
    monkeypatch.setattr(type(local), "mv", lambda self, a, b: (_ for _ in ()).throw(OSError("gone")))
    with pytest.raises(ExportError, match="gone"):
        write_bytes(place_of("sftp://host/b"), b"whole")
    assert [path.name for path in (tmp_path / "host").iterdir()] == ["a"]


def test_what_is_missing_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("artipg_dsl.extras.find_spec", lambda name: None)
    with pytest.raises(UserError, match="needs fsspec") as caught:
        Remote("s3://bucket").exists()
    assert "artipg_dsl[remote]" in caught.value.hint


def test_addresses_and_folders(tmp_path: Path) -> None:
    assert place_of("file:///a/b") == Path("/a/b") and place_of("out") == Path("out")
    assert place_of("s3://b/c/") == Remote("s3://b/c") and str(place_of("s3://b") / "x") == "s3://b/x"
    assert is_same(place_of(tmp_path), place_of(f"{tmp_path}/x/..")) and not is_same(Path("a"), Remote("s3://a"))
    with pytest.raises(UsageError):
        write_dataset(open_job(read_request("Globe")), "memory://x", OUTPUT, workers=Workers(2))

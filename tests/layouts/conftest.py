"""Folders in the layouts of the field, written once for each module."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from artipg_dsl.layouts.registry import LAYOUTS
from artipg_dsl.run.checksums import read_names
from artipg_dsl.run.job import open_job
from artipg_dsl.run.laying import check_layout, write_layout
from artipg_dsl.run.request import Request

Lay = Callable[..., Path]


@pytest.fixture(scope="module")
def lay(tmp_path_factory: pytest.TempPathFactory) -> Lay:
    """``lay("pcn", "Chair", "Laptop", n=10)``: a folder with objects of these categories."""

    def write(layout: str, *categories: str, n: int = 10, folder: Path | None = None, **options: object) -> Path:
        out = folder or tmp_path_factory.mktemp(layout)
        for category in categories:
            job = open_job(Request(category, seed=7, numbers=((0, n - 1),), checked=False))
            write_layout(job, out, LAYOUTS[layout], **options)  # type: ignore[arg-type]
        return out

    return write


def faults(folder: Path) -> list[str]:
    """What the folder's own reader finds, as text."""
    return [f"{place}: {fault}" for place, fault in check_layout(folder).faults]


def unlike(folder: Path) -> list[str]:
    """What it finds beside the model in files that have been changed: in a folder of an older version, which knows no checksums."""
    for record in (folder / ".layout").iterdir():
        if record.suffix != ".json":
            record.write_text("".join(f"{name}\n" for name in sorted(read_names(record))))
    return faults(folder)

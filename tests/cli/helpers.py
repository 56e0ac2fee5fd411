"""Run apgc, in this process or in one of its own."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from artipg_dsl.cli.main import main

ROOT = Path(__file__).parents[2]
CHEST = str(Path(__file__).parent / "programs" / "chest.apg")


class Apgc:
    """Call it with arguments; returns (exit code, stdout, stderr)."""

    def __init__(self, capture: pytest.CaptureFixture[str]):
        self.capture = capture

    def __call__(self, *arguments: object) -> tuple[int, str, str]:
        self.capture.readouterr()
        code = main([str(a) for a in arguments])
        out, err = self.capture.readouterr()
        assert "Traceback" not in err
        return code, out, err


def command(*arguments: object) -> list[str]:
    return [sys.executable, "-m", "artipg_dsl", *map(str, arguments)]


def environment(**more: str) -> dict[str, str]:
    return os.environ | {"PYTHONPATH": str(ROOT)} | more


def spawn(*arguments: object, hash_seed: str = "0") -> subprocess.CompletedProcess[str]:
    """The command in a process of its own."""
    return subprocess.run(
        command(*arguments), env=environment(PYTHONHASHSEED=hash_seed), capture_output=True, text=True, check=False
    )


def tree(folder: Path) -> dict[str, bytes]:
    return {str(p.relative_to(folder)): p.read_bytes() for p in sorted(folder.rglob("*")) if p.is_file()}

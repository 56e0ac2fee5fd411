"""What README and docs tell people to type."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest

from artipg_dsl.cli.main import build_parser
from artipg_dsl.cli.options.texts import EMITS
from artipg_dsl.session import Session

from .helpers import ROOT

PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", ROOT / "docs" / "cli.md", ROOT / "docs" / "index.md"]


def fences(page: Path, language: str) -> list[str]:
    return re.findall(rf"^```{language}\n(.*?)^```$", page.read_text(), re.MULTILINE | re.DOTALL)


def commands(page: Path) -> list[list[str]]:
    """The calls of apgc in the shell examples of a page, as lists of arguments."""
    found = []
    for fence in fences(page, "sh"):
        for line in fence.splitlines():
            for piece in line.split("&&"):
                words = shlex.split(piece, comments=True)
                if words and Path(words[0]).name == "apgc":
                    found.append(words[1:])
    return found


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_commands_are_understood(page: Path) -> None:
    found = commands(page)
    assert found
    for arguments in found:
        assert build_parser().parse_args(arguments).command == arguments[0]


def test_the_page_of_the_command_line_is_complete() -> None:
    text = (ROOT / "docs" / "cli.md").read_text()
    subcommands = build_parser()._subparsers._group_actions[0].choices  # type: ignore[union-attr]
    assert all(f"`apgc {name}" in text for name in subcommands)
    assert all(f"`--emit {name}`" in text or f"`{name}`" in text for name in EMITS)
    for name, command in subcommands.items():
        for action in command._actions:
            known = [option for option in action.option_strings if re.search(rf"(?<![\w-]){option}(?![\w-])", text)]
            assert known or not action.option_strings or action.dest == "help", f"{name} {action.option_strings}"


def test_the_first_category_samples() -> None:
    (text,) = fences(ROOT / "docs" / "index.md", "apg")
    assert Session.of_text(text).sampler.program.name == "Chest"


def test_the_python_of_the_readme_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (text,) = fences(ROOT / "README.md", "python")
    monkeypatch.chdir(tmp_path)
    for long, short in (("n=1000", "n=40"), (".points(2048)", ".points(16)")):
        assert long in text
        text = text.replace(long, short)
    names: dict = {}
    exec(text, names)
    assert (tmp_path / "robots" / "objects" / "000037" / "object.urdf").exists()
    assert names["points"].position.shape == (40, 16, 3)
    assert {"oven.glb", "oven.png"} <= {path.name for path in tmp_path.iterdir()}


def test_links_between_pages_lead_somewhere() -> None:
    for page in [*PAGES, ROOT / "docs" / "labels.md"]:
        for target in re.findall(r"\]\(([^)#:]+)(?:#[^)]*)?\)", page.read_text()):
            assert (page.parent / target).exists(), f"{page.name}: {target}"

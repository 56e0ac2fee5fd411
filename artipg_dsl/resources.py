"""Where the grammar, the library and the categories lie: in the installed package, or in a checkout beside it."""

from __future__ import annotations

from pathlib import Path

COMPILED = ".apgc"
"""What the names of compiled programs end in."""

_PACKAGE = Path(__file__).resolve().parent


def _folder(name: str) -> Path:
    packaged = _PACKAGE / "_data" / name
    return packaged if packaged.is_dir() else _PACKAGE.parent / name


def grammar_file() -> Path:
    """The file that defines the syntax."""
    return _folder("grammar") / "apg.lark"


def library_dir() -> Path:
    """The folder of the modules that ``use`` finds everywhere."""
    return _folder("library")


def categories_dir() -> Path:
    """The folder of the categories that are known by name."""
    return _folder("categories")

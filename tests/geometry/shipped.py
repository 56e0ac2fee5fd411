"""The primitives that the modules of the library declare, lowered from their text when a test asks for one."""

import re
from collections.abc import Iterator, Mapping
from functools import cache
from pathlib import Path

from artipg_dsl.diagnostics import Report
from artipg_dsl.graph.primitive import Primitive
from artipg_dsl.resources import library_dir
from artipg_dsl.session import Session
from artipg_dsl.solids import lower_own

_PRIMITIVE = re.compile(r"^primitive (\w+)(.*?)^}", re.MULTILINE | re.DOTALL)
_OVER_A_CURVE = re.compile(r"^ *param \w+ *: curve", re.MULTILINE)  # takes its shape from a use


@cache
def lowered(path: Path) -> dict[str, Primitive]:
    report = Report()
    found = {symbol.name: made.primitive for symbol, made in lower_own(Session.of(path).typed, report).items()}
    assert not report.diagnostics
    return found


class Shipped(Mapping[str, Primitive]):
    """By name. The names are read off the texts: each process of a run collects the tests, and few of them need the primitives."""

    def __init__(self) -> None:
        self.module = {
            name: path
            for path in sorted(library_dir().glob("*.apg"))
            for name, body in _PRIMITIVE.findall(path.read_text(encoding="utf-8"))
            if not _OVER_A_CURVE.search(body)
        }

    def __getitem__(self, name: str) -> Primitive:
        path = self.module[name]
        assert {n for n, p in self.module.items() if p == path} == set(lowered(path))
        return lowered(path)[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self.module)

    def __len__(self) -> int:
        return len(self.module)


SHIPPED = Shipped()

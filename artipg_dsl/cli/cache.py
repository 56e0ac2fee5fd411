"""``apgc cache``: what is kept between runs, and its removal."""

from __future__ import annotations

import argparse

from .. import cache
from ..errors import plural
from ..native import compiler

_KINDS = {
    "check": "findings",
    "tree": "syntax trees",
    "tables": "tables of the parser",
    "grammar": "the parser that explains mistakes",
    "solid": "lowered primitives that took long",
    "program": "compiled programs",
    "facts": "what surfaces and pieces are like",
    "memory": "how much memory objects take",
    "machine": "the compiled backend",
}


def run(options: argparse.Namespace) -> int:
    place = cache.folder()
    if place is None:
        print("nothing is kept: APGC_CACHE is off, or no home is known")
        return 0
    compiled = compiler.folder()
    found = [*cache.entries(place), *(cache.entries(compiled) if compiled is not None else ())]
    if options.action == "clear":
        number, total = cache.clear(found)
        print(f"removed {plural(number, 'file')} ({_size(total)}) from {place}")
        return 0
    print(f"{place}: {plural(len(found), 'file')}, {_size(sum(e.size for e in found))} of {_size(cache.MOST)} at most")
    for kind in sorted({entry.kind for entry in found}):
        held = [entry.size for entry in found if entry.kind == kind]
        print(f"  {_KINDS.get(kind, kind)}: {plural(len(held), 'file')}, {_size(sum(held))}")
    return 0


def _size(number: int) -> str:
    """Bytes in words."""
    return f"{number / (1 << 20):.1f} MB" if number >= 100_000 else f"{number / (1 << 10):.1f} kB"

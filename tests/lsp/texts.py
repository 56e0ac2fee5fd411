"""Texts with a mark at a place, and what the server knows of them."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from artipg_dsl.lsp.analysis import Analysis
from artipg_dsl.source import Source

SHELVES = """apg 1
use primitives { Cuboid }

## A board that lies.
template Board {
  param depth : length in 20cm .. 30cm = 25cm
  count holes in 1 .. 3 = 2
  part plank : Cuboid(size = [depth, 60cm, 2cm])
  let edge = depth / 10
}
"""
STAND = """apg 1
use primitives   { Cuboid }
use shelves      { Board }
use materials    { oak }
use vocabularies { semantic, affordance }

category Stand {
  ## From floor to board.
  param height : length in 30cm .. 60cm = 40cm
  param look   : choice plain | carved
  root part shelf : Board(depth = 28cm)
  part back : Cuboid(size = [2cm, 60cm, height])
  repeat leg[i] in 0 ..< 2 {
    let aside = (i - 1/2) * 50cm
    part post : Cuboid(size = [3cm, 3cm, height])
    connect post.top on shelf.bottom at y = shelf.center.y + aside
  }
  align back.bottom = shelf.top
  align back.back = shelf.back
  joint tilt : revolute shelf -> back about back.bottom.back range -10deg .. 0deg
  material oak on shelf, back, leg
  label semantic.shelf on shelf
  label semantic.panel on back
  label semantic.column on leg
  when look == plain {
    label affordance.support on shelf
  }
}
"""


class Texts:
    """Two files in a folder: a category, and the module that it uses."""

    def __init__(self, folder: Path):
        self.shelves, self.stand = folder / "shelves.apg", folder / "stand.apg"
        self.shelves.write_text(SHELVES)
        self.stand.write_text(STAND)

    def analysis(self, text: str, texts: Mapping[Path, Source] | None = None) -> Analysis:
        """What is known of the category if its text is this one."""
        return Analysis(Source(str(self.stand), text), texts or {})

    def at(self, old: str, new: str) -> tuple[Analysis, int]:
        """The category with ``new`` in place of ``old``, and where in it the mark ``|`` stood in ``new``."""
        assert STAND.count(old) == 1 and new.count("|") >= 1
        offset = STAND.index(old) + new.index("|")
        return self.analysis(STAND.replace(old, new.replace("|", "", 1))), offset

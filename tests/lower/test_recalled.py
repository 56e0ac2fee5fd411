"""Lowered primitives that are kept between runs: what a program is made of does not depend on them."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from artipg_dsl import cache
from artipg_dsl.graph.text import to_text
from artipg_dsl.lower.solids import primitives
from artipg_dsl.session import Session

TEXT = """apg 1
use primitives { Cylinder }
primitive Bump {
  param radius : length > 0  test 3cm .. 6cm
  param height : length > 0  test 1cm .. 2cm
  curve skin (v in 0 .. 1) = [radius * (1 - v), height * v]
  require height < radius else "too steep"
  solid = lathe([skin]) about z
}
category Knob {
  root part stem : Cylinder(radius = 1cm, height = 3cm)
  part bump : Bump(radius = 4cm, height = 15mm)
  connect bump.bottom on stem.top
}
"""


@pytest.fixture
def kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("APGC_CACHE", str(tmp_path / "kept"))
    return tmp_path / "kept"


@pytest.fixture
def made(monkeypatch: pytest.MonkeyPatch) -> Iterator[list[str]]:
    """The names of the primitives that are lowered."""
    names: list[str] = []

    def make(context, symbol, title, paths):
        names.append(title)
        return plain(context, symbol, title, paths)

    plain = primitives.make
    monkeypatch.setattr(primitives, "make", make)
    yield names


def lowered(name: str | Path) -> str:
    """The text of a program that is compiled anew."""
    lowering = Session.of(name).lowering
    assert lowering is not None
    return to_text(lowering.program)


@pytest.mark.parametrize("category", ["Faucet", "Bucket", "Pen"])
def test_a_program_is_the_same_of_kept_primitives(kept, made, monkeypatch, category):
    monkeypatch.setenv("APGC_CACHE", "off")
    without = lowered(category)
    assert made
    monkeypatch.setenv("APGC_CACHE", str(kept))
    assert lowered(category) == without
    made.clear()
    assert lowered(category) == without
    assert not made, "nothing is lowered twice"


def test_what_asks_and_offers_is_kept_too(kept, made):
    """The plain cylinder asks for positive sizes; the mug hands paths to its handle."""
    first = Session.of("Mug").lowering
    made.clear()
    second = Session.of("Mug").lowering
    assert not made
    for one, two in zip(first.context.solids.values(), second.context.solids.values(), strict=True):
        assert one.primitive.name == two.primitive.name
        assert (one.names, one.centred_size, one.possible) == (two.names, two.centred_size, two.possible)
        assert [(c.holds, c.sides, c.message, c.text, c.bend) for c in one.conditions] == [
            (c.holds, c.sides, c.message, c.text, c.bend) for c in two.conditions
        ]
        assert one.ports == two.ports
    assert any(s.ports for s in first.context.solids.values()) and any(s.paths for s in first.context.solids.values())


def test_damaged_entries_are_made_again(kept, made):
    without = lowered("Bucket")
    entries = sorted(kept.glob("solid-*"))
    assert entries
    for number, entry in enumerate(entries):
        body = cache.read(entry.name)
        assert body is not None
        wrong = (
            b"",
            b"%0 = const 1.0\n%0",
            b"[none none]",
            body[: len(body) // 2],
            body.replace(b"Primitive", b"Patch", 1),
        )
        cache.write(entry.name, wrong[number % len(wrong)])
    made.clear()
    assert lowered("Bucket") == without
    assert len(made) == len(entries)
    made.clear()
    assert lowered("Bucket") == without and not made


def test_another_text_is_another_primitive(kept, made, tmp_path):
    path = tmp_path / "knob.apg"
    path.write_text(TEXT)
    first = lowered(path)
    assert sorted(made) == ["Bump", "Cylinder"]
    made.clear()
    path.write_text(TEXT.replace("3cm)", "4cm)"))
    assert lowered(path) != first
    assert made == ["Bump"], "it stands in the edited text"
    made.clear()
    path.write_text(TEXT)
    assert lowered(path) == first and not made

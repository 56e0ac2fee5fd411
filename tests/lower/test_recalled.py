"""Lowered primitives that are kept between runs: what a program is made of does not depend on them."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from artipg_dsl import cache
from artipg_dsl.graph.writing import to_text
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
    for least in ("_LONG", "_BRIEF"):
        monkeypatch.setattr(primitives, least, 0.0)
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


@pytest.mark.slow
def test_a_program_is_the_same_of_kept_primitives(kept, made, monkeypatch):
    """Faucets have lathes, and spouts that are swept along paths which uses hand in."""
    monkeypatch.setenv("APGC_CACHE", "off")
    without = lowered("Faucet")
    monkeypatch.setenv("APGC_CACHE", str(kept))
    first = Session.of("Faucet").lowering
    made.clear()
    second = Session.of("Faucet").lowering
    assert not made, "nothing is lowered twice"
    assert len(first.context.typed.unshaped) < len(second.context.typed.unshaped), "what is kept needs no types"
    assert to_text(first.program) == to_text(second.program) == without
    for one, two in zip(first.context.solids.values(), second.context.solids.values(), strict=True):
        assert (one.names, one.centred_size, one.possible) == (two.names, two.centred_size, two.possible)
        assert [(c.holds, c.sides, c.message, c.text, c.bend) for c in one.conditions] == [
            (c.holds, c.sides, c.message, c.text, c.bend) for c in two.conditions
        ]
        assert one.ports == two.ports and one.digest == two.digest
    assert any(s.ports for s in first.context.solids.values()) and any(s.paths for s in first.context.solids.values())


def test_what_is_lowered_at_once_is_not_kept(kept, made, monkeypatch, tmp_path):
    for least in ("_LONG", "_BRIEF"):
        monkeypatch.setattr(primitives, least, 1e9)
    (tmp_path / "knob.apg").write_text(TEXT)
    lowered(tmp_path / "knob.apg")
    assert made and not list(kept.glob("solid-*"))


def test_damaged_entries_are_made_again(kept, made, tmp_path):
    path = tmp_path / "knob.apg"
    path.write_text(TEXT)
    without = lowered(path)
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
    assert lowered(path) == without
    assert len(made) == len(entries)
    made.clear()
    assert lowered(path) == without and not made


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

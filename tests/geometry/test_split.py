"""Formulas of primitives are kept between runs: what is read gives the same bits, and what is spoilt is made anew."""

import json

import numpy as np
import pytest

from artipg_dsl import cache
from artipg_dsl.geometry import facts, flat, patches, pieces
from artipg_dsl.geometry import split as splits
from artipg_dsl.geometry.patches import surfaces
from artipg_dsl.geometry.trial import draw_trial
from artipg_dsl.native.tape import read_tape
from artipg_dsl.session import Session

KEPT = ("position of", "tangents of", "inside", "corners of")


@pytest.fixture
def kept(primitives, tmp_path, monkeypatch):
    monkeypatch.setenv("APGC_CACHE", str(tmp_path / "kept"))
    forget()
    yield tmp_path / "kept"
    facts._changed.clear()
    forget()


@pytest.fixture(scope="module")
def primitives():
    """Some with exponents in their formulas, indexed patches, declared pieces."""
    every = {p.name: p for p in Session.of("Kettle").sampler.program.primitives.values()}
    return [every[name] for name in sorted(every) if every[name].parameters]


def forget():
    for held in (
        facts._facts,
        patches.position_split,
        patches.tangent_split,
        patches.inside_split,
        flat._corners,
        pieces._corners,
    ):
        held.cache_clear()


def values(primitive):
    """The bits of all that formulas of a primitive say of a few instances."""
    params = draw_trial(primitive)
    u, v = (a.ravel() for a in np.meshgrid([0.1, 0.5, 0.9], [0.2, 0.7], indexing="ij"))
    made = [
        patches.grid(split(primitive, patch), params, u, v)
        for split in (patches.position_split, patches.tangent_split)
        for patch in range(len(surfaces(primitive)))
    ]
    made.append(patches.grid(inside(primitive), params, u, v))
    made.append(flat.quads(primitive, params)[1])
    for numbers in pieces._alike(primitive):
        made += [cloud.points for cloud in pieces._declared(primitive, numbers, params)]
    return [np.asarray(array).tobytes() for array in made]


def inside(primitive):
    """The inside function in the plane z = 0."""
    found = patches.inside_split(primitive)
    flatly = splits.Split(primitive.parameters, found._rows, found._points, found._exponents)
    flatly.points = lambda rows, u, v: found.points(rows, u, v, np.zeros_like(u))
    return flatly


def test_kept_formulas_give_the_same_bits(kept, primitives, monkeypatch):
    first = [values(p) for p in primitives]
    facts.flush()
    forget()
    monkeypatch.setattr(splits.Split, "of", lambda *_: pytest.fail("made again"))
    monkeypatch.setattr(splits, "compile_formula", lambda *_: pytest.fail("made again"))
    assert [values(p) for p in primitives] == first


@pytest.mark.parametrize(
    "change",
    [
        lambda tape: None,
        lambda tape: tape | {"operations": tape["operations"] + " where"},
        lambda tape: tape | {"operations": "jump " + tape["operations"], "arguments": [0, *tape["arguments"]]},
        lambda tape: (
            tape | {"arguments": [9999 for _ in tape["arguments"]], "outputs": [9999 for _ in tape["outputs"]]}
        ),
        lambda tape: tape | {"arguments": [-1 for _ in tape["arguments"]], "outputs": [-1 for _ in tape["outputs"]]},
        lambda tape: tape | {"variables": tape["variables"] + 1},
        lambda tape: tape | {"variables": "x"},
        lambda tape: tape | {"constants": ["x"]},
        lambda tape: tape | {"outputs": [*tape["outputs"], 0]},
        lambda tape: {},
    ],
)
def test_spoilt_formulas_are_made_anew(kept, primitives, change):
    every = primitives[:3]
    first = [values(p) for p in every]
    facts.flush()
    for path in kept.glob("facts-*"):
        entry = json.loads(cache.read(path.name))
        for name in [name for name in entry if name.startswith(KEPT)]:
            held = entry[name]
            entry[name] = change(held) if "operations" in held else {**held, "points": change(held["points"])}
        cache.write(path.name, json.dumps(entry).encode())
    forget()
    assert [values(p) for p in every] == first


def test_a_tape_that_takes_what_is_not_there_is_none():
    tape = {"variables": 2, "constants": [1.0], "operations": "add mul", "arguments": [0, 1, 3, 2], "outputs": [4]}
    assert read_tape(tape).stepwise((2.0, 3.0)) == (5.0,)
    for wrong in (
        {"arguments": [0, 1, 4, 2]},
        {"arguments": [0, 1, 3]},
        {"outputs": [5]},
        {"arguments": [0, 1, 3, True]},
    ):
        with pytest.raises(ValueError):
            read_tape(tape | wrong)

"""What makes objects invalid does so where its guard holds: overlaps, faults, tilting, loops, preferences."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from artipg_dsl.runtime.batch import Batch
from artipg_dsl.session import Session
from artipg_dsl.validity.faults import find_faults
from artipg_dsl.validity.tree import Tree

from .guarded import HEAD, MADE, WAYS, P, plain, repeat, role, twice, units, when


def blamed(batch: Batch) -> set[tuple[int, str]]:
    """The objects, and of those with several units the unit, in which links collide."""
    found = find_faults(batch)
    names, first = batch.links().name, np.searchsorted(batch.links().owner, np.arange(len(batch)))
    hits = found.collisions
    return {
        (k, names[first[k] + link])
        for k, *pair in zip(hits.owner.tolist(), hits.first.tolist(), hits.second.tolist(), strict=True)
        for link in pair
    }


MIDDLE = "  align p.center.x = stand.center.x\n  align p.center.y = stand.center.y\n"
LOW = MIDDLE + P + "  joint pull : prismatic stand -> p along z range 0 .. 5cm\n  align p.bottom = stand.top - 1cm\n"


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize(
    "said", ['allow overlap stand, p because "it is meant"', "free p, stand"], ids=["overlap", "free"]
)
def test_what_may_overlap_under_a_guard(way: Callable[..., str], said: str) -> None:
    batch = Session.of_text(HEAD + way(LOW, said, "")).sampler.batch(
        np.arange(MADE if way in (when, role) else 1), seed=2
    )
    wrong = blamed(batch)
    for number, prefix, truth in units(way, batch):
        assert ((number, plain(prefix) + "p") in wrong) == (not truth), (number, prefix)


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize(
    ("parts", "said", "word"),
    [
        (
            MIDDLE + P + "  connect p to stand\n  align p.bottom = stand.top + {}\n",
            'allow floating p because "it is meant"',
            "touches nothing",
        ),
        (
            MIDDLE
            + P
            + "  joint pull : prismatic stand -> p along z range 0 .. 5cm\n  align p.bottom = stand.top + 2mm + {}\n",
            "clear p from stand by 5mm",
            "clear",
        ),
    ],
    ids=["floating", "clear"],
)
def test_faults_under_a_guard(way: Callable[..., str], parts: str, said: str, word: str) -> None:
    """Of two units one is at fault: that for which the statement holds, then the other."""
    excuses = word != "clear"
    for at_fault in (True, False) if way in (repeat, twice) else (True,):
        far = {when: "{}", role: "{}", repeat: "({0} if i == 0 else {1})", twice: "({0} if a == yes else {1})"}[way]
        bad, good = ("5mm", "0mm") if excuses else ("0mm", "2cm")
        pair = (bad, good) if at_fault else (good, bad)
        body = parts.format(far.format(*pair) if way in (repeat, twice) else bad)
        batch = Session.of_text(HEAD + way(body, said, "")).sampler.batch(
            np.arange(MADE if way in (when, role) else 1), seed=2
        )
        wrong = {k for fault in find_faults(batch).others if word in fault.words for k in fault.objects.tolist()}
        if way in (repeat, twice):
            assert (0 in wrong) == (at_fault != excuses), at_fault
        else:
            for number, _, truth in units(way, batch):
                assert (number in wrong) == (truth != excuses)


@pytest.mark.parametrize("way", WAYS)
def test_stability_under_a_guard(way: Callable[..., str]) -> None:
    lean = (
        P.replace("4cm", "40cm") + "  connect p.bottom on stand.top at x = stand.center.x + 30m, y = stand.center.y\n"
    )
    batch = Session.of_text(HEAD + way(lean, "require stable", "")).sampler.batch(
        np.arange(MADE if way in (when, role) else 1), seed=2
    )
    wrong = {k for fault in find_faults(batch).others if "tips" in fault.words for k in fault.objects.tolist()}
    assert wrong == {number for number, _, truth in units(way, batch) if truth}


ARMS = """part one : Cuboid(size = [1cm, 1cm, 1cm])
  joint turn : revolute stand -> one about line(at = stand.center, along = z) range -30deg .. 30deg
  part p : Cuboid(size = [1cm, 1cm, 1cm])
  joint pull : revolute stand -> p about line(at = stand.center, along = z) range -30deg .. 30deg
  align one.center.x = stand.center.x + 20cm
  align p.center.x = stand.center.x + 20cm
"""


@pytest.mark.parametrize("way", WAYS)
def test_a_loop_is_closed_under_a_guard(way: Callable[..., str]) -> None:
    batch = Session.of_text(HEAD + way(ARMS, "close one.center on p.center", "")).sampler.batch(
        np.arange(MADE if way in (when, role) else 1), seed=2
    )
    leader, joints = Tree(batch).leader, batch.joints()
    for number, prefix, truth in units(way, batch):
        row = next(
            k for k, name in enumerate(joints.name) if joints.owner[k] == number and name == plain(prefix) + "pull"
        )
        assert (leader[row] != row) == truth


def test_prefer_under_a_guard() -> None:
    parts = "count q in 0 .. 1\n"
    batch = Session.of_text(HEAD + when(parts, "prefer q == 1 weight 6", "prefer q == 0 weight 6")).sampler.batch(
        np.arange(60), seed=2, candidates=8
    )
    drawn = [batch.drawn(k) for k in range(60)]
    assert np.mean([(v["a"] == "yes") == (v["q"] == 1) for v in drawn]) > 0.9

"""Objects, their points, labels and annotations are the same bytes with either backend. ``ARTIPG_EVERY=1``: of every category."""

import os

import numpy as np
import pytest

from artipg_dsl.annotate.points import label_points
from artipg_dsl.export.content import Content
from artipg_dsl.export.registry import choose_formats
from artipg_dsl.geometry import points
from artipg_dsl.random import key
from artipg_dsl.session import Session, categories
from artipg_dsl.validity.faults import find_faults

from .machine import bits, needs_compiler

EVERY = os.environ.get("ARTIPG_EVERY") == "1"


def made(name: str) -> dict[str, bytes]:
    batch = Session.of(name).sampler.batch(np.arange(3), seed=5)
    sites = batch.sites()
    found = {
        f"{s.number}.{k}": bits(v) for s in sites for k, v in {**s.params, "at": s.translation, "r": s.rotation}.items()
    }
    placed = points.sample(sites, len(batch), 600, key(5, "points"), batch.numbers.astype(np.uint64))
    found |= {name: bits(getattr(placed, name)) for name in ("site", "row", "patch", "u", "v", "position", "normal")}
    labels = label_points(batch, sites, placed)
    found |= {name: bits(value) for name, value in (labels.fields | {"semantic": labels.semantic}).items()}
    wrong = find_faults(batch)
    found["faults"] = bits(wrong.objects()) + b"".join(bits(fault.objects) for fault in wrong.others)
    for entry in choose_formats(["points", "annotation"]):
        found[entry.name] = entry.shard_bytes(batch, Content())
    return found


@needs_compiler
@pytest.mark.parametrize("name", sorted(categories()) if EVERY else ["Microwave"])
def test_either_backend_gives_the_same_bytes(name, nothing_kept, using):
    using("numpy")
    expected = made(name)
    using("c")
    found = made(name)
    assert list(found) == list(expected)
    assert not [what for what in expected if found[what] != expected[what]]

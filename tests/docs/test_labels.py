"""What docs/labels.md lists is what is written."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from artipg_dsl.annotate.annotation import annotate
from artipg_dsl.export.shards import point_arrays
from artipg_dsl.runtime.batch import Batch
from artipg_dsl.session import Session

TEXT = (Path(__file__).parents[2] / "docs" / "labels.md").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def batch() -> Batch:
    return Session.of("Microwave").sampler.batch(np.arange(8), seed=3)


def told(mark: str) -> dict[str, list[str]]:
    """The rows between ``<!-- mark -->`` and ``<!-- end -->``: what the first cell names, and the other cells."""
    found = re.search(rf"<!-- {mark} -->\n(.*?)<!-- end -->", TEXT, re.DOTALL)
    assert found is not None
    cells = [[c.strip() for c in line.split("|")[1:-1]] for line in found[1].split("\n") if line.startswith("| `")]
    return {row[0].strip("`"): row[1:] for row in cells}


def test_arrays(batch: Batch) -> None:
    arrays = {k: v for k, v in point_arrays(batch, 64).items() if "." not in k}
    shapes = {"B": (8,), "B, n": (8, 64), "B, n, 3": (8, 64, 3)}
    assert {k: (str(v.dtype), v.shape) for k, v in arrays.items()} == {
        name: (dtype, shapes[shape]) for name, (dtype, shape, _) in told("arrays").items()
    }


def test_annotation(batch: Batch) -> None:
    annotations = annotate(batch)
    assert set(annotations[0]) == set(told("keys"))
    entries = told("entries")
    for key, (names,) in entries.items():
        found = next(entry for annotation in annotations for entry in annotation[key])
        assert list(found) == re.findall(r"`(\w+)`", names)


def test_vocabularies(batch: Batch) -> None:
    listed = {name: tuple(re.findall(r"`(\w+)`", words)) for name, (words,) in told("vocabularies").items()}
    assert listed == batch.program.vocabularies

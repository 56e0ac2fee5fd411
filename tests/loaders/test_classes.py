"""Classes of one's own instead of the words of `semantic`."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from artipg_dsl.errors import UsageError, UserError
from artipg_dsl.loaders import Stored, Stream

MINE = {"door": "leaf", "handle": "leaf", "*": "rest"}


@pytest.fixture(scope="module")
def odd(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A category whose vocabulary is its own, and numbers the words of the chest otherwise."""
    path = tmp_path_factory.mktemp("odd") / "odd.apg"
    path.write_text(
        "apg 1\nuse primitives { Cuboid }\nvocabulary semantic { door plinth }\ncategory Odd {\n"
        "  root part block : Cuboid(size = [1m, 1m, 1m])\n  part top : Cuboid(size = [1m, 1m, 1m])\n"
        "  connect top.bottom on block.top\n  label semantic.plinth on block\n  label semantic.door on top\n}\n"
    )
    return path


def test_words_are_gathered_into_classes(chest: Path, folders: list[Path]) -> None:
    plain, mine = (Stream(chest, batch=4, points=1024, classes=c) for c in (None, MINE))
    assert mine.words["semantic"] == ["unlabelled", "leaf", "rest"]
    before, after = plain.batch(0)["semantic"], mine.batch(0)["semantic"]
    words = np.array(plain.words["semantic"])[before]
    assert set(words.ravel()) == {"body", "door", "handle"}
    assert np.array_equal(after, np.where(np.isin(words, ["door", "handle"]), 1, 2)) and after.dtype == np.int64
    few = Stream(chest, batch=4, points=1024, classes={"door": "door"}).batch(0)["semantic"]
    assert np.array_equal(few, np.where(words == "door", 1, 0)), "what is not named is unlabelled"
    stored, own = Stored(folders), Stored(folders, classes=MINE)
    words = np.array(stored.words["semantic"])[stored.take([0, 1])["semantic"]]
    assert np.array_equal(own.take([0, 1])["semantic"], np.where(np.isin(words, ["door", "handle"]), 1, 2))


def test_vocabularies_that_differ_are_mixed(chest: Path, odd: Path) -> None:
    with pytest.raises(UsageError, match="Chest and Odd number their semantic classes differently"):
        Stream([chest, odd])
    found = Stream([chest, odd], batch=4, points=256, classes=MINE | {"plinth": "plinth"})
    assert found.words["semantic"] == ["unlabelled", "leaf", "rest", "plinth"]
    made = found.batch(0)
    assert set(made["semantic"][made["category"] == 0].ravel()) == {1, 2}
    assert set(made["semantic"][made["category"] == 1].ravel()) == {1, 3}


@pytest.mark.parametrize(
    ("classes", "told"),
    [
        ({"dor": "leaf"}, "there is no word `dor` in `semantic`"),
        ({"door": 3}, "the class of `door` is 3"),
        ({}, "classes is {}"),
    ],
)
def test_wrong_classes_are_told(chest: Path, folders: list[Path], classes: dict[str, str], told: str) -> None:
    with pytest.raises(UserError, match=told):
        Stream(chest, classes=classes)
    with pytest.raises(UserError, match=told):
        Stored(folders, classes=classes)

"""Labels guide the search: what bears a word is matched with what bears the same."""

from __future__ import annotations

import numpy as np
import pytest

import artipg_dsl as apg
from artipg_dsl.fit import fitting, products
from artipg_dsl.fit.compare import clouds, compare, words_of
from artipg_dsl.fit.fitting import fit, usual_size
from artipg_dsl.fit.match import nearest
from artipg_dsl.fit.measure import agreement, surfaces
from artipg_dsl.fit.model import Model, Placed
from artipg_dsl.fit.pose import Frame, Posed, pose, targets
from artipg_dsl.fit.reading import Cloud
from artipg_dsl.fit.words import OTHER, Nearest, Twofold, factors, unlike

from .helpers import TEXT, N
from .test_states import LITTLE

NAMES = ("trunk_7", "lid", "knob", "dust")
WORDS = {"trunk_7": "body", "lid": "door", "knob": "handle"}


def labelled(samples: apg.Samples, model: Model, noise: float) -> list[Posed]:
    """The surfaces with noise, and with the names that annotators gave them."""
    points, chance, found = samples.points(8000), np.random.default_rng(3), []
    ids = {samples.batch.program.vocabularies["semantic"].index(WORDS[n]): k for k, n in enumerate(NAMES[:3])}
    for place, word in zip(points.position, points.semantic, strict=True):
        at = place + chance.normal(size=place.shape) * noise
        label = np.array([ids.get(int(one), 3) for one in word])
        found.append(pose(Cloud(at, None, label, NAMES), Frame(front="x", unit="m"), ".npz", usual_size(model)))
    return found


MEANT = np.array([2, 5, 9])


def test_words_are_unlike_if_both_say_something():
    word = np.array([0, 2, 5, 9])
    assert unlike(np.array([2, 2, 2, 0]), np.array([2, 5, 0, 5])).tolist() == [False, True, False, False]
    first, second = factors(word, MEANT)[0], factors(word, MEANT)[1]
    assert (first @ second.T == unlike(word[:, None], word[None])).all()


@pytest.mark.parametrize("silent", [0.0, 0.4, 1.0])
def test_the_nearest_is_so_with_what_another_word_adds(silent: float):
    chance = np.random.default_rng(4)
    points, asked = chance.random((2, 200, 3)), chance.random((2, 50, 3))
    word, theirs = (
        np.where(chance.random((2, n)) < silent, 0, MEANT[chance.integers(3, size=(2, n))]) for n in (200, 50)
    )
    apart = ((asked[:, :, None] - points[:, None]) ** 2).sum(axis=3)
    expected = (apart + OTHER**2 * unlike(theirs[:, :, None], word[:, None])).argmin(axis=2)
    assert (nearest(points, asked, (word, theirs), MEANT)[0] == expected).all()
    tree = Nearest(points.reshape(-1, 3), np.repeat([0, 1], 200), word.ravel(), MEANT)
    found, _ = tree.find(asked.reshape(-1, 3), np.repeat([0, 1], 50), theirs.ravel())
    assert (found.reshape(2, 50) - [[0], [200]] == expected).all()


def test_the_nearest_is_found_both_ways_a_few_rows_at_a_time(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(products, "_MOST", 8000)
    chance = np.random.default_rng(5)
    points, asked = chance.random((2, 170, 6)), chance.random((2, 130, 6))
    silent = np.zeros((2, 170), dtype=np.int64), np.zeros((2, 130), dtype=np.int64)
    there, here = nearest(points, asked, silent, MEANT[:0])
    apart = ((asked[:, :, None] - points[:, None]) ** 2).sum(axis=3)
    assert (there == apart.argmin(axis=2)).all() and (here == apart.argmin(axis=1)).all()


def test_what_no_word_is_meant_by_says_nothing(samples: apg.Samples, model: Model):
    batch = model.assembled([(samples.batch, np.arange(N))])
    made = clouds(batch, 512)
    body, door, handle = (batch.program.vocabularies["semantic"].index(word) for word in ("body", "door", "handle"))
    assert set(np.unique(words_of(batch, made, np.array([body, door, handle])))) == {body, door, handle}
    assert set(np.unique(words_of(batch, made, np.array([door])))) == {0, door}
    assert not words_of(batch, made, np.array([], dtype=np.int64)).any()


def test_formulas_that_say_what_is_labelled_leave_it_open():
    text = TEXT.replace("label semantic.door on lid\n", "label semantic.door on lid where n.z > 0.5\n")
    batch = apg.load(text, n=1, seed=5).batch
    semantic = batch.program.vocabularies["semantic"]
    words = np.array([semantic.index(word) for word in ("body", "door", "handle")])
    assert semantic.index("door") not in words_of(batch, clouds(batch, 512), words)


def test_a_wrong_word_is_as_far_off_as_what_is_not_there(samples: apg.Samples, model: Model):
    posed = labelled(samples, model, 0.0)
    batch, every = model.assembled([(samples.batch, np.arange(N))]), np.arange(N)
    still, semantic = Placed(np.ones(N), np.zeros((N, 3))), batch.program.vocabularies["semantic"]

    def score(words: dict[str, str]) -> np.ndarray:
        said = [np.array([*(semantic.index(words[n]) if n in words else 0 for n in NAMES), 0])[p.label] for p in posed]
        meant = sorted({semantic.index(word) for word in words.values()})
        return compare(batch, every, still, targets(posed, said, meant), 2048).score

    right, swapped = score(WORDS), score(WORDS | {"trunk_7": "door", "lid": "body"})
    assert np.abs(right - score({})).max() < 1e-3 and (swapped > right + 0.03).all()


@pytest.mark.slow
def test_knobs_in_noise_are_counted_by_their_labels(
    samples: apg.Samples, model: Model, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Their 2 cm are hidden by 1 cm of noise, in which the labels of the true objects agree by 0.2 to 0.4 only."""
    posed = labelled(samples, model, 0.01)
    blind, asked = fit(model, posed, effort=LITTLE), []
    monkeypatch.setattr(fitting, "agreement", lambda *given: asked.append(given) or agreement(*given))
    told = fit(model, posed, effort=LITTLE, words=WORDS)
    true = samples["knobs"].astype(int).tolist()
    assert [one.values["knobs"] for one in told] == true != [one.values["knobs"] for one in blind]
    batch = samples.batch
    whole, _ = surfaces(batch, batch.sites(), np.ones(N), np.zeros((N, 3)))
    for k, (one, (*cloud, _, meant, names)) in enumerate(zip(told, asked, strict=True)):
        assert one.told["iou"]["handle"] >= 0.6 * agreement(*cloud, whole[k], meant, names)["handle"] > 0.1


def test_places_alone_tell_what_is_nearest_by_both_where_they_can() -> None:
    chance = np.random.default_rng(4)
    points, asked = (
        np.concatenate([chance.random((m, 3)), 0.06 * np.eye(3)[chance.integers(3, size=m)]], axis=1)
        for m in (900, 400)
    )
    of, theirs, none = chance.integers(2, size=900), chance.integers(2, size=400), np.zeros(900, dtype=np.int64)
    both = Twofold(points, of, none, np.zeros(0))
    found = both.find(asked, theirs, none[:400])
    for axes, (index, far) in zip((6, 3), found, strict=True):
        apart = np.sqrt(((asked[:, None, :axes] - points[:, :axes]) ** 2).sum(axis=2))
        apart = np.where(theirs[:, None] == of, apart, np.inf)
        assert (index == apart.argmin(axis=1)).all() and far == pytest.approx(apart.min(axis=1))
    assert (found[0][0] != found[1][0]).any()
    reach = chance.random(400) * 0.09
    assert both.within(asked, theirs, reach)[found[1][1] <= reach].all()
    assert not both.within(asked, theirs, reach).all()

"""Batches that are made on the way: the right arrays, and the same whoever asks."""

import pickle
from pathlib import Path

import numpy as np
import pytest

import artipg_dsl as apg
from artipg_dsl.errors import UserError
from artipg_dsl.loaders import Jitter, Stream


@pytest.fixture(scope="module")
def stream(chest: Path) -> Stream:
    return Stream(chest, size=10, batch=4, points=64, seed=3)


def test_a_batch_holds_what_the_objects_have(stream: Stream, chest: Path) -> None:
    batch, points = stream.batch(1), apg.sample(chest, numbers=range(4, 8), seed=3).points(64)
    assert batch["object"].tolist() == [4, 5, 6, 7] and batch["category"].tolist() == [0] * 4
    np.testing.assert_array_equal(batch["points"], points.position.astype(np.float32))
    np.testing.assert_array_equal(batch["semantic"], points.semantic)
    assert batch["semantic"].dtype == np.int64
    assert (
        {"body", "door"}
        <= {stream.words["semantic"][k] for k in np.unique(batch["semantic"])}
        <= {"body", "door", "handle"}
    )


def test_the_last_batch_is_shorter_and_there_is_no_other(stream: Stream) -> None:
    assert [len(stream.batch(k)["object"]) for k in range(len(stream))] == [4, 4, 2]
    with pytest.raises(IndexError, match="3 batches"):
        stream.batch(3)


def test_a_stream_may_be_longer_than_any_memory(chest: Path) -> None:
    endless = Stream(chest, size=2**60, batch=1, points=8)
    np.testing.assert_array_equal(next(endless.batches(range(5, 2**60)))["object"], [5])
    with pytest.raises(UserError, match="up to 6 there are objects"):
        endless.batch(0, 7)


def test_epochs_count_from_0(stream: Stream) -> None:
    for wrong in (-1, 0.5, 2**32, 2**64):
        with pytest.raises(UserError, match="epoch is"):
            stream.batch(0, wrong)  # type: ignore[arg-type]


def test_another_epoch_has_other_objects_unless_it_is_to_have_the_same(stream: Stream, chest: Path) -> None:
    assert stream.batch(0, 2)["object"].tolist() == [20, 21, 22, 23]
    same = Stream(chest, size=10, batch=4, points=64, seed=3, fresh=False, states="random", task="pose")
    first, second = same.batch(0, 0), same.batch(0, 1)
    np.testing.assert_array_equal(first["object"], second["object"])
    np.testing.assert_array_equal(first["npcs"], second["npcs"])
    lid = first["link"] == 1
    assert (np.abs(first["points"] - second["points"]).max(axis=-1) > 1e-3)[lid].mean() > 0.9  # it opens elsewhere
    np.testing.assert_array_equal(first["points"][~lid], second["points"][~lid])


def test_batches_that_are_made_together_are_those_that_are_made_alone(chest: Path, box: Path) -> None:
    both = Stream([chest, box], "pose", size=11, batch=4, points=16, states="random", transforms=[Jitter()])
    together = list(both.batches([2, 0, 1], epoch=1))
    assert [len(batch["object"]) for batch in together] == [3, 4, 4]
    for k, batch in zip((2, 0, 1), together, strict=True):
        alone = both.batch(k, epoch=1)
        assert list(batch) == list(alone)
        for name, array in alone.items():
            np.testing.assert_array_equal(batch[name], array)


def test_categories_take_turns(chest: Path, box: Path) -> None:
    both = Stream([chest, box], "affordance", size=6, batch=5, points=32)
    batch = both.batch(0)
    assert both.categories == ["Chest", "Box"] and both.words["affordance"] == ["contain", "lift", "push"]
    assert batch["category"].tolist() == [0, 1, 0, 1, 0] and batch["object"].tolist() == [0, 0, 1, 1, 2]
    assert batch["affordance"].shape == (5, 32, 3)
    said = batch["affordance"].any(axis=1)
    np.testing.assert_array_equal(said[:, :2], (batch["category"] == 1)[:, None].repeat(2, axis=1))
    np.testing.assert_array_equal(said[:, 2], batch["category"] == 0)


def test_motion_is_that_of_the_points(chest: Path) -> None:
    batch = Stream(chest, "pose", size=3, batch=3, points=64, states="open=30deg").batch(0)
    moves = np.abs(batch["motion"]).max(axis=-1) > 0
    np.testing.assert_array_equal(moves, batch["link"] == 1)


def test_completion_has_what_one_camera_sees(chest: Path) -> None:
    batch = Stream(chest, "completion", size=2, batch=2, points=128, view={"width": 80, "height": 60}).batch(0)
    assert batch["partial"].shape == batch["points"].shape == (2, 128, 3)
    assert (batch["partial"].min(axis=1) > batch["points"].min(axis=1) - 0.05).all()
    above = {"poses": [{"eye": [0.1, 0, 3]}]}
    seen = Stream(chest, "completion", size=1, batch=1, points=128, view=above).batch(0)["partial"]
    assert seen[..., 2].min() > batch["points"][:1, :, 2].max() - 0.01


def test_transforms_do_not_depend_on_the_batch(chest: Path) -> None:
    from artipg_dsl.loaders import Drop, Jitter, Normalise, Occlude, Scale, Turn, View

    steps = [Normalise(), Turn(), Scale(), Occlude(), View(), Drop(), Jitter()]
    large, small = (Stream(chest, size=4, batch=n, points=64, transforms=steps) for n in (4, 1))
    for name, values in large.batch(0, 5).items():
        np.testing.assert_array_equal(values[2], small.batch(2, 5)[name][0], err_msg=name)


def test_it_travels_to_another_process(stream: Stream) -> None:
    there = pickle.loads(pickle.dumps(stream))
    np.testing.assert_array_equal(there.batch(0)["points"], stream.batch(0)["points"])


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"task": "segmentatoin"}, "segmentation"),
        ({"size": 0}, "size is 0"),
        ({"batch": 2.5}, "batch is 2.5"),
        ({"states": "random:4"}, "4 states"),
        ({"batch": True}, "batch is True"),
        ({"fresh": "no"}, "fresh is 'no'"),
        ({"transforms": Jitter()}, "give a list"),
        ({"transforms": [Jitter]}, "is not a transform"),
        ({"transforms": [lambda arrays: arrays]}, "cannot be called with the arrays"),
        ({"states": "ajar"}, "not a joint state"),
        ({"set": {"widht": "50cm"}}, "width"),
        ({"prior": {"knbos": {"1": 1}}}, "knobs"),
        ({"prior": {"draws": {"Box": {"knobs": {"1": 1}}}}}, "says nothing of Chest"),
        ({"prior": "partnot"}, "there is no prior partnot"),
        ({"task": None}, "a task is named by a text, not None"),
        ({"states": None}, "states is None: text is needed"),
        ({"classes": 3}, "classes is 3"),
        ({"task": "completion", "view": 3}, "view is 3"),
        ({"task": "completion", "view": {"views": 5}}, "view has 5 cameras"),
        ({"task": "completion", "view": {"widht": 5}}, "`widht` is not known"),
        ({"points": 10**12}, "points is 1000000000000"),
        ({"size": 2**70}, "size is"),
    ],
)
def test_what_is_wrong_is_said_at_once(chest: Path, options: dict[str, object], message: str) -> None:
    with pytest.raises(UserError, match=message):
        Stream(chest, **options)  # type: ignore[arg-type]


def test_categories_are_names_each_once(chest: Path) -> None:
    for categories, message in (
        (None, "categories is None"),
        ([3], r"categories is \[3\]"),
        ([chest, chest], "named twice"),
    ):
        with pytest.raises(UserError, match=message):
            Stream(categories)  # type: ignore[arg-type]
    with pytest.raises(UserError, match="the number of a batch is 0.5"):
        Stream(chest, size=2, batch=1, points=8).batch(0.5)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("transform", "message"),
    [
        (lambda arrays, draws: None, "gives NoneType"),
        (lambda arrays, draws: {"semantic": arrays["semantic"]}, "gives no `points`"),
        (lambda arrays, draws: arrays | {"extra": 3}, "makes 'extra' int"),
        (lambda arrays, draws: arrays | {"name": np.array(["a", "b"])}, "makes 'name' of type <U1"),
        (lambda arrays, draws: arrays | {"semantic": arrays["semantic"] * 0.5}, "'semantic' of type float64.*int64"),
        (lambda arrays, draws: {"points": arrays["points"][0]}, r"makes 'points' of shape \(8, 3\)"),
    ],
)
def test_a_transform_gives_arrays_of_as_many_objects(chest: Path, transform: object, message: str) -> None:
    data = Stream(chest, size=2, batch=2, points=8, transforms=[transform])  # type: ignore[list-item]
    with pytest.raises(UserError, match=message):
        data.batch(0)


def test_arrays_keep_their_types(chest: Path) -> None:
    noise = Stream(
        chest, size=2, batch=2, points=8, transforms=[lambda a, draws: a | {"points": a["points"] + draws.normal(8, 3)}]
    )
    assert noise.batch(0)["points"].dtype == np.float32


def test_what_is_wrong_with_any_category_is_said_at_once(chest: Path, tmp_path: Path) -> None:
    other = tmp_path / "other.apg"
    other.write_text(chest.read_text().replace("joint open", "joint lift").replace("Chest", "Other"))
    with pytest.raises(UserError, match="Other has no joint `open`"):
        Stream([chest, other], states="open=30deg")


def test_values_are_set_of_all_categories_or_of_each(chest: Path, box: Path, tmp_path: Path) -> None:
    options: dict[str, object] = {"size": 4, "batch": 4, "points": 32}

    def widths(set: object) -> list[float]:
        made = Stream([chest, box], set=set, **options).batch(0)["points"]  # type: ignore[arg-type]
        return np.round(np.ptp(made[..., 1], axis=1).astype(np.float64), 1).tolist()

    assert widths({"width": "60cm"}) == [0.6] * 4
    assert widths({str(chest): {"width": "60cm"}, str(box): {"width": "40cm"}}) == [0.6, 0.4, 0.6, 0.4]
    plain, one = widths(None), widths({str(box): {"width": "60cm"}})
    assert one[0::2] == plain[0::2] and one[1::2] == [0.6] * 2
    other = tmp_path / "other.apg"
    other.write_text(chest.read_text().replace("width", "breadth"))
    with pytest.raises(UserError, match="is for one of the categories"):
        Stream([chest, other], set={"width": "60cm"})
    with pytest.raises(UserError, match="settings for Door, which is not streamed"):
        Stream([chest, box], set={"Door": {"width": "60cm"}})


def test_classes_have_to_be_numbered_alike(chest: Path, tmp_path: Path) -> None:
    other = tmp_path / "other.apg"
    text = chest.read_text().replace(
        "use vocabularies { semantic, affordance }", "vocabulary semantic { door body handle }"
    )
    kept = [line for line in text.splitlines() if "affordance" not in line]
    other.write_text("\n".join(kept).replace("Chest", "Other"))
    with pytest.raises(UserError, match="Chest and Other number"):
        Stream([chest, other])


def test_a_prior_weighs_the_categories_that_it_speaks_of(chest: Path, box: Path) -> None:
    options: dict[str, object] = {"size": 12, "batch": 12, "points": 64, "seed": 3}
    alone = Stream(chest, prior={"knobs": {"3": 1}}, **options)  # type: ignore[arg-type]
    handles = alone.batch(0)["instance"].reshape(12, -1)
    expected = apg.sample(chest, 12, 3, prior={"knobs": {"3": 1}}).points(64).instance
    np.testing.assert_array_equal(handles, expected)
    there = pickle.loads(pickle.dumps(alone))
    np.testing.assert_array_equal(there.batch(0)["points"], alone.batch(0)["points"])
    given = {"draws": {"Chest": {"knobs": {"3": 1}}}}
    both, plain = Stream([chest, box], prior=given, **options), Stream([chest, box], **options)  # type: ignore[arg-type]
    same = (both.batch(0)["points"] == plain.batch(0)["points"]).all(axis=(1, 2))
    assert same[1::2].all() and not same[0::2].all()
    with pytest.raises(UserError, match="says nothing of Box, Chest"):
        Stream([box, chest], prior={"draws": {"Door": {}}}, **options)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({"view": {"width": 32}}, "segmentation has no camera to look through"),
        ({"detail_strength": 0.5}, "detail_strength scales details, and there are none"),
        ({"seed": 1.5}, "seed is 1.5: a whole number is needed"),
    ],
)
def test_arguments_that_would_change_nothing_are_told(chest: Path, wrong: dict, said: str) -> None:
    with pytest.raises(UserError, match=said):
        Stream(chest, size=2, batch=2, points=8, **wrong)

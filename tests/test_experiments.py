"""The experiments: what they read, their folds, scores and tables, and a short run of each."""

from __future__ import annotations

import json
import shutil
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

import artipg_dsl as apg
from artipg_dsl.errors import UserError
from experiments.clouds import Clouds, draw, normalise
from experiments.mutants import Fit, fit_each, mutants
from experiments.ours import LEAST, our_motion, our_parts, our_ways
from experiments.page import written
from experiments.part import Part, part_arrays
from experiments.pose import Pose, box_iou, distance_of_lines, fit_pose, line_error, rotation_error
from experiments.real import Real, read_real, real_motion, real_shapes
from experiments.scores import chamfer_l1, f1_score, f_score, mean_iou, paired_test
from experiments.study import Arm, Metric, by_object, folds_of, run, summarise
from experiments.warp import tilt_and_scale, turn, turn_and_scale, warp_locally

REAL = Path(__file__).parents[1] / "experiments" / "real"


@pytest.fixture(scope="module")
def objects() -> list[Real]:
    return read_real(REAL)


# ---------------------------------------------------------------- real objects


def test_real_objects_say_what_moves_and_whose_they_are(objects: list[Real]) -> None:
    shapes, real = real_shapes(objects), real_motion(objects)
    assert (len(shapes), len(shapes.known)) == (42, 23) and (len(real), len(real.known)) == (15, 10)
    moves = real["moves"]
    assert moves.any(axis=1).all() and not moves.all(axis=1).any()
    assert np.abs(np.sqrt((real["points"] ** 2).sum(axis=2)).max(axis=1) - 1.0).max() < 1e-6
    for one in objects:
        assert one.normals is not None and np.abs((one.normals**2).sum(axis=1) - 1.0).max() < 1e-6
    for path in REAL.rglob("joints.json"):
        record = json.loads(path.read_text(encoding="utf-8"))
        assert record["licence"] and record["source"], path


def write(
    place: Path, points: np.ndarray, link: np.ndarray, up: str = "z", joints: object = None, front: str = "x"
) -> None:
    place.mkdir(parents=True)
    hinge = {
        "type": "revolute",
        "parent": "base",
        "child": "lid",
        "axis": [1, 0, 0],
        "origin": [0, 0, 0],
        "lower": -1.5,
        "upper": 0,
    }
    np.savez(place / "cloud.npz", points=points, link_id=link, link_names=np.array(["base", "lid"]))
    told = {"up": up, "front": front, "joints": [hinge] if joints is None else joints}
    (place / "joints.json").write_text(json.dumps(told), encoding="utf-8")


def tall(n: int = 400) -> tuple[np.ndarray, np.ndarray]:
    """A tall box whose top is another link."""
    points = np.random.default_rng(0).uniform(-1, 1, (n, 3)) * [0.1, 0.2, 0.5]
    return points, (points[:, 2] > 0.2).astype(np.int16)


def test_objects_stand_upright_and_to_the_front(tmp_path: Path) -> None:
    points, link = tall()
    for up, front in (("x", "y"), ("y", "z"), ("z", "x"), ("z", "-y"), ("-z", "x")):
        x, z = (np.eye(3)["xyz".index(name[-1])] * (-1 if "-" in name else 1) for name in (front, up))
        frame = np.stack([x, np.cross(z, x), z])  # the object's axes in the file
        place = tmp_path / f"{up} {front}"
        write(place / "Box" / "tall", points @ frame, link, up, front=front)
        (one,) = read_real(place)
        assert one.points == pytest.approx(points)
        assert one.joints[0].axis == pytest.approx(-frame[:, 0])  # the file's x, the way that it opens
        assert list(one.moved_by()) == [-1, 0]


def test_joints_open_along_their_axis(tmp_path: Path) -> None:
    """The range of the hinge goes from -1.5 to 0, so it opens against the axis that the file tells."""
    write(tmp_path / "Box" / "tall", *tall())
    (one,) = read_real(tmp_path)
    assert one.joints[0].axis.tolist() == [-1.0, 0.0, 0.0] and one.joints[0].kind == "revolute"


def test_names_of_categories_are_mapped(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    points, link = tall()
    write(tmp_path / "real" / "Cupboard" / "one", points, link)
    with pytest.raises(UserError, match="no category .* is shipped: Cupboard .*--map"):
        read_real(tmp_path / "real")
    told = tmp_path / "map.json"
    told.write_text('{"cupboard": "storagefurniture"}', encoding="utf-8")
    assert read_real(tmp_path / "real", told)[0].title == "StorageFurniture one"
    write(tmp_path / "real" / "Rocket" / "two", points, link)
    assert len(read_real(tmp_path / "real", told)) == 1
    assert "left out: 1 of Rocket" in capsys.readouterr().out
    for text, wrong in (
        ("{", "is not JSON"),
        ("[1]", "no map of names"),
        ('{"a": "Spaceship"}', "a is mapped to Spaceship"),
    ):
        told.write_text(text, encoding="utf-8")
        with pytest.raises(UserError, match=wrong):
            read_real(tmp_path / "real", told)
    with pytest.raises(UserError, match="cannot be read"):
        read_real(tmp_path / "real", tmp_path / "none.json")


def test_a_wrong_folder_is_told(tmp_path: Path) -> None:
    with pytest.raises(UserError, match="has no objects"):
        read_real(tmp_path)
    with pytest.raises(UserError, match="there is no folder"):
        read_real(tmp_path / "none")
    points, link = tall()
    for name, (p, k, joints), wrong in (
        ("few", (points[:9], link[:9], []), "256 or more"),
        ("links", (points, link + 1, []), "one of 2 links"),
        ("short", (points, link[:9], []), "for each of 400 points"),
        ("nan", (points * np.nan, link, []), "no numbers"),
        ("joint", (points, link, [{"type": "revolute", "parent": "base", "child": "door"}]), "door"),
        (
            "axis",
            (
                points,
                link,
                [{"type": "revolute", "parent": "base", "child": "lid", "axis": [0, 0, 0], "origin": [0, 0, 0]}],
            ),
            "axis",
        ),
    ):
        write(tmp_path / name / "Box" / "one", p, k, "z", joints)
        with pytest.raises(UserError, match=wrong):
            read_real(tmp_path / name)
    for up, front in (("as in source", "x"), ("z", "-z")):
        write(tmp_path / f"up {front}" / "Box" / "one", points, link, up, front=front)
        with pytest.raises(UserError, match=f"up {up}, front {front}.* is missing or wrong"):
            read_real(tmp_path / f"up {front}")
    write(tmp_path / "zip" / "Box" / "one", points, link)
    (tmp_path / "zip" / "Box" / "one" / "cloud.npz").write_bytes(b"PK nothing")
    with pytest.raises(UserError, match="cloud.npz and joints.json are read"):
        read_real(tmp_path / "zip")
    write(tmp_path / "still" / "Box" / "one", points, link, "z", [])
    with pytest.raises(UserError, match="link that a joint moves"):
        real_motion(read_real(tmp_path / "still"))


def test_folders_of_partnet_mobility_are_read(tmp_path: Path) -> None:
    """Those that we write: the door of a microwave turns about the same line as in our own frame, up to scale."""
    ours = apg.sample("Microwave", n=1, seed=3)
    (place,) = ours.export(tmp_path, "partnet-mobility")
    found = read_real(tmp_path)
    assert [one.category for one in found] == ["Microwave"]
    (one,) = found
    assert one.normals is not None and len(one.points) == 10_000 and np.ptp(one.points, axis=0)[2] > 0.1
    door = next(joint for joint in one.joints if joint.kind == "revolute" and (one.link == joint.child).mean() > LEAST)
    assert abs(door.axis[2]) > 0.99
    part = one.points[one.moved_by()[one.link] == one.joints.index(door)]
    away = np.sqrt(((part - door.origin)[:, :2] ** 2).sum(axis=1))
    assert away.min() < 0.2 * away.max()  # the part reaches to its hinge
    mobility = next(tmp_path.rglob("mobility_v2.json"))
    mobility.write_text("[{}]", encoding="utf-8")
    with pytest.raises(UserError, match="mobility_v2.json: .* is missing or wrong"):
        read_real(tmp_path)
    (mobility.parent / "meta.json").unlink()
    with pytest.raises(UserError, match="model_cat"):
        read_real(tmp_path)


# ---------------------------------------------------------------- ours


def test_small_parts_go_with_what_they_are_on() -> None:
    """The keys of a microwave are too small to count, its door is not; at rest and open the same points move."""
    ours = our_motion(("Microwave",), 3, 512, seed=2)
    assert len(ours) == 6 and ours.names[3] == "Microwave 0 open"
    share = ours["moves"].mean(axis=1)
    assert (share > LEAST).all() and (share < 0.7).all()
    assert (ours["moves"][:3] == ours["moves"][3:]).all()


def test_doors_open_the_way_that_they_have_room() -> None:
    """Of a closed microwave; the lid of a laptop, which rests open, goes both ways."""
    ours = our_ways(("Laptop", "Microwave"), 2, 512, seed=2)
    length = np.sqrt((ours["opens"] ** 2).sum(axis=-1))
    assert set(length.round(4).ravel()) == {0.0, 1.0}
    assert (ours["opens"][2:, :, 0].sum(axis=1) > 10).all()  # to the front
    assert ours["both"][:2].any(axis=1).all() and not ours["both"][2:].any()
    assert not ours["both"][length == 0.0].any()


@pytest.mark.slow
def test_a_prior_draws_the_categories_that_it_speaks_of() -> None:
    """Of tables nearly all have something that moves by it, half of them as declared; laptops are drawn as declared."""
    known = ("Laptop", "Table")
    declared, prior = (our_motion(known, 12, 512, seed=2, prior=prior) for prior in (None, "partnet"))
    still = [int((~made["moves"].any(axis=1))[24:36].sum()) for made in (declared, prior)]
    assert still[0] >= 6 and still[1] <= 3
    assert (declared["points"][:24] == prior["points"][:24]).all()


@pytest.fixture(scope="module")
def fits(objects: list[Real], tmp_path_factory: pytest.TempPathFactory) -> list[Fit]:
    """A real microwave, fitted, as the object 1 of some."""
    (one,) = [one for one in objects if one.category == "Microwave"]
    return fit_each({1: one}, tmp_path_factory.mktemp("fits"))


@pytest.mark.slow
def test_mutants_are_of_the_object_that_was_fitted(fits: list[Fit]) -> None:
    """They go with it where it is held out; in its details they are other points of the same objects."""
    bare, worn = (mutants(fits, ("Door", "Microwave"), ("cpa",), 3, 512, details) for details in (False, True))
    assert (
        bare.origin.tolist() == [1] * 6 and bare.category.tolist() == [1] * 6 and not len(bare.without(np.array([1])))
    )
    assert (bare["moves"].mean(axis=1) > LEAST).all() and (bare["moves"] == worn["moves"]).all()
    assert not np.allclose(bare["points"][0], bare["points"][1], atol=1e-3)  # of one another
    away = np.sqrt(((bare["points"] - worn["points"]) ** 2).sum(axis=-1))
    assert 0.001 < away.mean() < 0.1


def test_canonical_places_give_the_pose_the_box_and_the_joint() -> None:
    """Of doors at rest and open; the hinge is at one edge."""
    parts = our_parts(("Microwave",), 2, 512, seed=2)
    assert len(parts) >= 4 and not parts.of_real
    for k in range(len(parts)):
        own, points, npcs = (parts[name][k] for name in ("own", "points", "npcs"))
        pose = fit_pose(npcs[own], points[own], np.random.default_rng(0))
        assert np.abs(pose.scale * npcs @ pose.rotation.T + pose.shift - points).max() < 1e-4
        assert np.abs(npcs[own]).max() <= 0.5 and abs(2 * np.sqrt((pose.half**2).sum()) - 1.0) < 0.1
        assert parts["hinged"][k].all() and parts["hinge"][k, 0, 0] < -0.3


def test_frames_of_parts() -> None:
    """x along the joint, y from the hinge to the part or as far up as can be."""
    points, link = tall()
    door = Part(points, link == 1, np.array([0.0, 1.0, 0.0]), np.array([-0.1, 0.0, 0.3]))
    x, y, z = door.frame().T
    assert x.tolist() == [0, 1, 0] and y[0] > 0.5 and np.allclose(np.cross(x, y), z)
    drawer = Part(points, link == 1, np.array([1.0, 0.0, 0.0]), None)
    assert np.allclose(drawer.frame()[:, 1], [0, 0, 1])
    sash = Part(points, link == 1, np.array([0.0, 0.0, 1.0]), None)
    assert np.allclose(np.linalg.det(sash.frame()), 1.0)
    arrays = part_arrays([door, drawer])
    assert arrays["points"].shape == (2, 512, 3) and arrays["own"].sum(axis=1).min() > 256
    assert arrays["hinged"].any(axis=1).tolist() == [True, False]


# ---------------------------------------------------------------- scores


def test_scores() -> None:
    truth = np.array([[True, True, False, False], [False] * 4])
    found = np.array([[True, False, False, False], [False] * 4])
    assert mean_iou(found, truth) == pytest.approx([(1 / 2 + 2 / 3) / 2, 1.0])
    assert f1_score(found[0], truth[0]) == pytest.approx(2 / 3) and f1_score(found[1], truth[1]) == 1.0
    same = np.linspace(0, 1, 12)
    assert paired_test(same, same) == 1.0
    assert paired_test(same + 0.1, same, rounds=20_000) < 0.001
    assert paired_test(same + np.tile([0.1, -0.1], 6), same, rounds=20_000) > 0.5


def test_distances_of_clouds() -> None:
    square = np.array([[[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]]])
    assert chamfer_l1(square + [0, 0, 0.25], square) == pytest.approx([0.25])
    assert chamfer_l1(square[:, :2], square) == pytest.approx([(0.0 + 0.5) / 2])
    assert f_score(square[:, :2], square, 0.01) == pytest.approx([2 * 1.0 * 0.5 / 1.5])
    assert f_score(square + 9.0, square, 0.01) == pytest.approx([0.0])


def test_poses() -> None:
    draws = np.random.default_rng(4)
    npcs = draws.uniform(-0.3, 0.3, (200, 3))
    rotation = np.linalg.qr(draws.normal(size=(3, 3)))[0]
    rotation *= np.sign(np.linalg.det(rotation))
    points = 0.7 * npcs @ rotation.T + [1.0, 2.0, 3.0]
    said = npcs + np.where(np.arange(200)[:, None] < 40, draws.normal(0.0, 0.5, (200, 3)), 0.0)  # a fifth is wrong
    pose = fit_pose(said, points, np.random.default_rng(0))
    assert rotation_error(pose.rotation, rotation) < 1e-3 and pose.scale == pytest.approx(0.7)
    assert pose.shift == pytest.approx([1.0, 2.0, 3.0])
    whole, half = (
        Pose(rotation, pose.shift, 1.0, np.full(3, 0.5)),
        Pose(rotation, pose.shift, 1.0, np.array([0.25, 0.5, 0.5])),
    )
    assert box_iou(whole, whole) == 1.0 and box_iou(half, whole) == pytest.approx(0.5, abs=0.03)
    assert box_iou(whole, Pose(rotation, pose.shift + 9.0, 1.0, whole.half)) == 0.0
    x, y = np.eye(3)[:2]
    assert line_error(x, -x) == 0.0 and line_error(x, y) == pytest.approx(90.0)
    assert distance_of_lines(np.zeros(3), x, np.array([5.0, 0, 2]), x) == pytest.approx(2.0)
    assert distance_of_lines(np.zeros(3), x, np.array([5.0, 3, 2]), y) == pytest.approx(2.0)


# ---------------------------------------------------------------- folds


def clouds(origin: list[int], known: tuple[str, ...] = ("Box",)) -> Clouds:
    count = len(origin)
    points = np.arange(count, dtype=np.float32)[:, None, None] * np.ones((1, 8, 3), dtype=np.float32)
    names = tuple(f"{of}:{k}" for k, of in enumerate(origin))
    return Clouds({"points": points}, np.zeros(count, dtype=np.int64), known, names, np.array(origin))


def test_no_network_sees_what_it_is_judged_on_or_what_was_made_from_it() -> None:
    """Objects 0 to 4, of which 1 has two clouds; mutants of them; and objects of ours."""
    real, mutants, ours = clouds([0, 1, 1, 2, 3, 4]), clouds([0, 0, 1, 2, 3, 4, 4]), clouds([-1, -1, -1])
    arms = {"ours": Arm(("ours",)), "real": Arm(("real",)), "mutants": Arm(("mutants", "ours"))}
    trained: list[tuple[Arm, list[int]]] = []

    def train(arm: Arm, sources: Sequence[Clouds], seed: list[int]) -> set[int]:
        trained.append((arm, seed))
        return {int(of) for source in sources for of in source.origin}

    def judge(seen: set[int], tested: Clouds, seed: int) -> dict[str, np.ndarray]:
        assert not seen & set(tested.origin.tolist())
        return {"score": tested.origin + 10.0 * seed}

    found = run(real, {"real": real, "mutants": mutants, "ours": ours}, arms, train, judge, 2, 3, lambda line: None)
    assert [seed for arm, seed in trained if arm is arms["ours"]] == [[0], [1]]  # has seen no real object: once a seed
    assert [seed for arm, seed in trained if arm is arms["mutants"]] == [[s, k] for s in (0, 1) for k in (0, 1, 2)]
    fold = folds_of(real, 3)
    assert fold[1] == fold[2] and set(fold) == {0, 1, 2}
    for scores in found.values():
        assert scores["score"].tolist() == [[0, 1, 1, 2, 3, 4], [10, 11, 11, 12, 13, 14]]
    names, means = by_object(real, found)
    assert len(names) == 5 and means["real"]["score"].tolist() == [[0, 1, 2, 3, 4], [10, 11, 12, 13, 14]]


def test_pairs_are_compared_object_by_object() -> None:
    one = np.array([[0.5, 0.6, 0.7], [0.7, 0.8, 0.9]])
    found = {"a": {"cd": one}, "b": {"cd": one + np.array([0.1, 0.1, -0.05])}}
    told = summarise(["x", "y", "z"], found, {"cd": Metric("CD", "lower")}, [("a", "b")])
    assert told["arms"]["a"]["cd"] == {"mean": 0.7, "over_seeds": [0.6, 0.8], "objects": {"x": 0.6, "y": 0.7, "z": 0.8}}
    (pair,) = told["pairs"]
    assert (pair["difference"], pair["better_on"], pair["of"]) == (-0.05, 2, 3)


def test_drawn_batches_take_as_many_of_each_source() -> None:
    made = draw([clouds([0, 1, 2]), clouds([-1] * 5)], 6, 4, np.random.default_rng(0))
    assert made["points"].shape == (6, 4, 3) and made["category"].tolist() == [0] * 6
    assert (made["points"][:3] <= 2).all()


def test_changed_clouds_are_other_shapes_of_the_same_points() -> None:
    points = normalise(np.random.default_rng(1).normal(size=(3, 200, 3)))
    for change in (turn_and_scale, tilt_and_scale, warp_locally):
        one, again, other = (change(points, np.random.default_rng(seed)) for seed in (5, 5, 6))
        assert np.array_equal(one, again) and not np.allclose(one, other)
        assert np.isfinite(one).all() and np.abs(one).max() < 5.0
    few = turn(np.tile([[1.0, 0.0, 0.5]], (500, 1, 1)), np.random.default_rng(2), np.pi / 3)
    assert 0.5 <= few[..., 0].min() < 0.52 and few[..., 1].min() < -0.8 and few[..., 1].max() > 0.8


def test_the_page_says_what_was_found() -> None:
    page = (REAL.parent / "README.md").read_text(encoding="utf-8")
    assert written(page, REAL.parent / "results") == page, "python -m experiments.page writes it anew"
    for path in (REAL.parent / "results").glob("*.json"):
        assert f"<!-- {path.stem}: arms -->" in page and json.loads(path.read_text(encoding="utf-8"))["seeds"] >= 3


# ---------------------------------------------------------------- networks

TORCH = "PyTorch is large and not in the extra `test`: pip install 'artipg_dsl[torch]'"


@pytest.fixture
def few(tmp_path: Path) -> Path:
    """A folder of three real objects."""
    for name in ("Laptop", "Microwave", "Oven"):
        shutil.copytree(REAL / name, tmp_path / "few" / name)
    return tmp_path / "few"


@pytest.mark.parametrize("name", ["moving", "mutated", "completion", "parts", "critic"])
def test_an_experiment_runs_and_repeats(
    name: str, few: Path, tmp_path: Path, request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Mutants are of the microwave alone: in the fold that holds it out there are none."""
    torch = pytest.importorskip("torch", reason=TORCH)
    from importlib import import_module

    from experiments.training import perform

    if name == "mutated":
        fits = request.getfixturevalue("fits")
        monkeypatch.setattr("experiments.mutated.fit_each", lambda objects, folder: fits)
    torch.set_num_threads(1)
    experiment = getattr(import_module(f"experiments.{name}"), name.title())()
    one, again = (perform(experiment, few, None, 1, 1, 2, 0.005, tmp_path / f"{k}.json") for k in "ab")
    for told in (one, again):
        del told["cpu_minutes"]
    assert one == again and json.loads((tmp_path / "a.json").read_text(encoding="utf-8"))["arms"] == one["arms"]
    assert set(one["arms"]) == set(experiment.arms) and set(one["metrics"]) == set(experiment.metrics)
    assert {pair["of"] for pair in one["pairs"]} == {4 if name == "completion" else 3}
    with pytest.raises(UserError, match="cannot be held out in 9 folds"):
        perform(experiment, few, None, 1, 1, 9, 0.005, tmp_path / "c.json")
    with pytest.raises(UserError, match="has no arm nobody"):
        perform(experiment, few, None, 1, 1, 2, 0.005, tmp_path / "c.json", ["real", "nobody"])


def test_some_arms_alone_are_what_they_are_among_all(few: Path, tmp_path: Path) -> None:
    pytest.importorskip("torch", reason=TORCH)
    from experiments.moving import Moving
    from experiments.training import perform

    every = perform(Moving(), few, None, 1, 1, 2, 0.005, tmp_path / "a.json")
    some = perform(Moving(), few, None, 1, 1, 2, 0.005, tmp_path / "b.json", ["ours", "real"])
    assert some["arms"] == {arm: every["arms"][arm] for arm in ("real", "ours")}
    assert [(pair["one"], pair["other"]) for pair in some["pairs"]] == [("ours", "real")]


def test_networks_learn() -> None:
    torch = pytest.importorskip("torch", reason=TORCH)
    from experiments.moving import Moving

    torch.set_num_threads(1)
    ours, moving = our_motion(("Laptop",), 4, 512, seed=2), Moving()
    before, after = (
        moving.judge(moving.train(Arm(("ours",)), [ours], [0], steps), ours, 0)["mean_iou"].mean() for steps in (5, 60)
    )
    assert after > before + 0.1


def test_a_completed_cloud_is_as_far_off_as_said() -> None:
    torch = pytest.importorskip("torch", reason=TORCH)
    from experiments.network import chamfer

    one, other = (np.random.default_rng(k).normal(size=(2, n, 3)) for k, n in ((0, 30), (1, 50)))
    told = chamfer(torch.from_numpy(one), torch.from_numpy(other)).item()
    assert told == pytest.approx(chamfer_l1(one, other).mean())

"""The experiment on what moves: its clouds, its scores, and a short run of its networks."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest

from artipg_dsl.errors import UserError
from experiments.clouds import LEAST, normalise, read_real, sample_ours
from experiments.scores import mean_iou, paired_test
from experiments.warp import turn_and_scale, warp_locally

REAL = Path(__file__).parents[1] / "experiments" / "real"


def test_real_objects_say_what_moves_and_whose_they_are() -> None:
    real = read_real(REAL)
    assert len(real) == 15 and len(real.known) == 10
    assert real.moves.any(axis=1).all() and not real.moves.all(axis=1).any()
    assert np.abs(np.sqrt((real.points**2).sum(axis=2)).max(axis=1) - 1.0).max() < 1e-6
    for path in REAL.rglob("joints.json"):
        record = json.loads(path.read_text(encoding="utf-8"))
        assert record["licence"] and record["source"], path


def test_the_up_axis_is_turned_to_z(tmp_path: Path) -> None:
    """A tall box whose top moves, told with each axis up."""
    points = np.random.default_rng(0).uniform(-1, 1, (400, 3)) * [0.1, 0.2, 0.5]
    link = (points[:, 2] > 0.2).astype(np.int16)
    joints = [{"type": "revolute", "parent": "base", "child": "lid"}]
    for up in ("x", "y", "z", "-z"):
        place = tmp_path / up / "Box" / "tall"
        place.mkdir(parents=True)
        turned = (
            points[:, [1, 0, 2]] * [1, 1, -1] if up == "-z" else np.roll(points, {"x": 1, "y": 2, "z": 0}[up], axis=1)
        )
        np.savez(place / "cloud.npz", points=turned, link_id=link, link_names=np.array(["base", "lid"]))
        (place / "joints.json").write_text(json.dumps({"up": up, "joints": joints}), encoding="utf-8")
        found = read_real(tmp_path / up)
        assert found.points[0][found.moves[0]][:, 2].min() > found.points[0][~found.moves[0]][:, 2].max()
        order = np.random.default_rng(0).permutation(len(points))
        matrix = np.linalg.lstsq(np.c_[points[order], np.ones(400)], found.points[0], rcond=None)[0][:3]
        assert np.linalg.det(matrix) > 0.0  # turned, not mirrored


def test_a_wrong_folder_is_told(tmp_path: Path) -> None:
    with pytest.raises(UserError, match="no object with a joint"):
        read_real(tmp_path)
    place = tmp_path / "Box" / "one"
    place.mkdir(parents=True)
    np.savez(place / "cloud.npz", points=np.zeros((4, 3)))
    (place / "joints.json").write_text('{"up": "z", "joints": []}', encoding="utf-8")
    with pytest.raises(UserError, match="cloud.npz: .*link_id"):
        read_real(tmp_path)


def test_small_parts_go_with_what_they_are_on() -> None:
    """The keys of a microwave are too small to count, its door is not; at rest and open the same points move."""
    ours = sample_ours(["Microwave"], 3, 512, seed=2)
    assert len(ours) == 6 and ours.names[3] == "Microwave 0 open"
    share = ours.moves.mean(axis=1)
    assert (share > LEAST).all() and (share < 0.7).all()
    assert (ours.moves[:3] == ours.moves[3:]).all()


def test_scores() -> None:
    truth = np.array([[True, True, False, False], [False] * 4])
    found = np.array([[True, False, False, False], [False] * 4])
    assert mean_iou(found, truth) == pytest.approx([(1 / 2 + 2 / 3) / 2, 1.0])
    same = np.linspace(0, 1, 12)
    assert paired_test(same, same) == 1.0
    assert paired_test(same + 0.1, same, rounds=20_000) < 0.001
    assert paired_test(same + np.tile([0.1, -0.1], 6), same, rounds=20_000) > 0.5


def test_changed_clouds_are_other_shapes_of_the_same_points() -> None:
    points = normalise(np.random.default_rng(1).normal(size=(3, 200, 3)))
    for change in (turn_and_scale, warp_locally):
        one, again, other = (change(points, np.random.default_rng(seed)) for seed in (5, 5, 6))
        assert np.array_equal(one, again) and not np.allclose(one, other)
        assert np.isfinite(one).all() and np.abs(one).max() < 5.0


def test_a_network_learns_what_moves() -> None:
    torch = pytest.importorskip(
        "torch", reason="PyTorch is large and not in the extra `test`: pip install 'artipg_dsl[torch]'"
    )
    from experiments.moving import judge, train
    from experiments.network import Segmenter

    torch.manual_seed(0)
    torch.set_num_threads(1)
    ours = sample_ours(["Laptop"], 4, 512, seed=2)
    network = Segmenter(1)
    before = judge(network, ours, 0).mean()
    train(network, [ours], 60, np.random.default_rng(0), turn_and_scale)
    assert judge(network, ours, 0).mean() > before + 0.1


def test_the_page_says_what_was_found() -> None:
    page = (REAL.parent / "README.md").read_text(encoding="utf-8")
    found = json.loads((REAL.parent / "results" / "moving.json").read_text(encoding="utf-8"))
    for arm in found["arms"].values():
        seeds = ", ".join(f"{100 * value:.1f}" for value in arm["over_seeds"])
        assert re.search(rf"\| \**{100 * arm['mean_iou']:.1f}\** \| {re.escape(seeds)} \|", page), seeds
    for pair in found["pairs"]:
        row = f"| {100 * pair['difference']:+.1f} | {pair['better_on']} of {pair['of']} | {pair['p']:.2f} |"
        assert row in page, row

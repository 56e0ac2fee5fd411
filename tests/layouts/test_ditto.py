"""Ditto: scenes read by the formulas of its loader, faults that the reader finds."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from artipg_dsl.errors import UserError
from artipg_dsl.export.containers import npz_bytes
from artipg_dsl.layouts import ditto as layout

from .conftest import Lay, faults, unlike


@pytest.fixture(scope="module", autouse=True)
def small() -> Iterator[None]:
    """Fewer places, scenes and pixels: what is tested does not depend on how many."""
    usual = layout.PROBES, layout.MOST, layout._CAMERAS
    layout.PROBES, layout.MOST, layout._CAMERAS = 4000, 2, replace(layout._CAMERAS, width=80, height=80)
    yield
    layout.PROBES, layout.MOST, layout._CAMERAS = usual


@pytest.fixture(scope="module")
def ditto(lay: Lay) -> Path:
    return lay("ditto", "StorageFurniture", n=1)


def read(folder: Path) -> dict[str, dict[str, np.ndarray]]:
    found = {}
    for path in sorted(folder.glob("Shape2Motion/StorageFurniture_train/scenes/*.npz")):
        with np.load(path) as held:
            found[path.stem] = dict(held)
    return found


def test_scenes_are_read_by_the_loaders_formulas(ditto: Path) -> None:
    """As ``geo_art_dataset_v0.py`` does: the screw carries what is told apart, the part that moves is `joint_index` + 1."""
    every = read(ditto)
    assert len(every) == 2
    for name, held in every.items():
        axis = held["screw_axis"]
        point = np.cross(axis, held["screw_moment"])
        step = float(held["state_end"] - held["state_start"])
        mask, start = held["pc_seg_start"], held["pc_start"].astype(float)
        assert start.shape == held["pc_start_end"].shape == (12288, 3) and 100 < mask.sum() < 12000
        moved = held["pc_start_end"].astype(float)
        assert (moved[~mask] == start[~mask]).all() and np.abs(step) > 0.01
        if held["joint_type"]:
            assert moved[mask] == pytest.approx(start[mask] + step * axis, abs=1e-6)
        else:
            near, far = (a[mask] - point - np.outer((a[mask] - point) @ axis, axis) for a in (start, moved))
            assert np.linalg.norm(near, axis=1) == pytest.approx(np.linalg.norm(far, axis=1), abs=1e-5)
            angle = np.arctan2(np.cross(near, far) @ axis, (near * far).sum(axis=1))
            assert angle[np.linalg.norm(near, axis=1) > 0.05] == pytest.approx(step, abs=1e-3)
        within = held["start_occ_list"]
        assert within.dtype == bool and within.shape[0] == sum(other.startswith(name[:-1]) for other in every) + 1
        front = within[int(held["joint_index"]) + 1]
        assert front.sum() > 5 and (within[0] & ~front).sum() > 20 and within.sum(axis=0).max() <= 2
        # places within the part that moves lie near its cloud, not near the rest of it
        probes = held["start_p_occ"].astype(float)[front]
        low, high = start[mask].min(axis=0) - 0.01, start[mask].max(axis=0) + 0.01
        assert ((probes > low) & (probes < high)).all(axis=1).mean() > 0.6, "what is not seen may reach farther"
        assert held["start_occ_density"][np.argwhere(front)].shape == (front.sum(), 1, 1), (
            "the loader squeezes it twice"
        )


def test_the_folder_is_read_back_and_faults_are_found(ditto: Path) -> None:
    assert not faults(ditto)
    path = sorted(ditto.glob("Shape2Motion/*/scenes/*.npz"))[0]
    with np.load(path) as file:
        held = dict(file)
    held["screw_moment"] = -held["screw_moment"]
    held["state_end"] = held["state_end"] + 0.1
    held["start_occ_density"] = held["start_occ_density"][:, 0]
    path.write_bytes(npz_bytes(held))
    found = unlike(ditto)
    for fault in ("pc_start_end by its screw differ", "densities are no column", "state_end differ"):
        assert any(fault in line for line in found), fault


@pytest.mark.slow
def test_what_carries_too_little_is_not_used(lay: Lay) -> None:
    """Handles of doors: their places are so few that Ditto would see none that moves. What is left is numbered without gaps."""
    folder = lay("ditto", "Door", n=3)
    scenes = {path.stem: dict(np.load(path)) for path in folder.glob("Shape2Motion/*/scenes/*.npz")}
    assert len({name.rsplit("_", 1)[0] for name in scenes}) == 3, "each door turns or slides"
    for name, held in scenes.items():
        own = [other for other in scenes if other.startswith(name[:-1])]
        assert int(held["joint_index"]) == int(name[-1]) < len(own) == len(held["start_occ_list"]) - 1
        within = held["start_occ_list"]
        assert within[int(held["joint_index"]) + 1].sum() >= 0.005 * within.any(axis=0).sum() > 0
        assert min(held["pc_seg_start"].mean(), held["pc_seg_end"].mean()) >= 0.005
    assert not faults(folder)


def test_a_category_without_such_joints_is_refused(lay: Lay) -> None:
    with pytest.raises(UserError, match="no joint of Scissors is one that Ditto can learn"):
        lay("ditto", "Scissors", n=1)

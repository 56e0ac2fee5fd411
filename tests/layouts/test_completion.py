"""Completion: clouds read from their bytes, and partial ones where a camera would have them."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial import cKDTree

from artipg_dsl import sample
from artipg_dsl.errors import UserError
from artipg_dsl.layouts.pcd import pcd_bytes, read_pcd
from artipg_dsl.layouts.registry import LAYOUTS

from .conftest import Lay, faults, unlike


def points(path: Path) -> np.ndarray:
    """As a reader of PCD does: the header's counts, then rows of three floats."""
    head, _, body = path.read_bytes().partition(b"DATA binary\n")
    fields = dict(line.split(" ", 1) for line in head.decode().splitlines()[1:])
    assert (fields["FIELDS"], fields["SIZE"], fields["TYPE"]) == ("x y z", "4 4 4", "F F F")
    made = np.frombuffer(body, np.float32).reshape(-1, 3)
    assert len(made) == int(fields["POINTS"]) == int(fields["WIDTH"]) * int(fields["HEIGHT"])
    return made


@pytest.fixture(scope="module")
def pcn(lay: Lay) -> Path:
    return lay("pcn", "Microwave", "Laptop", n=3, shares=(1, 1, 1))


@pytest.mark.some
def test_pcn_has_what_its_readers_ask_for(pcn: Path) -> None:
    assert not faults(pcn)
    classes = json.loads((pcn / "PCN.json").read_text())
    assert [(own["taxonomy_id"], own["taxonomy_name"]) for own in classes] == [
        ("03642806", "laptop"),
        ("03761084", "microwave"),
    ]
    for own in classes:
        for split, views in (("train", 8), ("val", 1), ("test", 1)):
            (name,) = own[split]
            whole = points(pcn / split / "complete" / own["taxonomy_id"] / f"{name}.pcd")
            assert len(whole) == 16384
            assert np.linalg.norm(np.ptp(whole, axis=0)) == pytest.approx(1, abs=1e-5)
            folder = pcn / split / "partial" / own["taxonomy_id"] / name
            assert sorted(path.name for path in folder.iterdir()) == [f"{k:02d}.pcd" for k in range(views)]
            for path in folder.iterdir():
                assert len(points(path)) >= 2048
        single = pcn / "test" / "partial" / own["taxonomy_id"] / f"{own['test'][0]}.pcd"
        assert single.read_bytes() == (single.with_suffix("") / "00.pcd").read_bytes()


def test_partial_clouds_lie_on_the_whole_one_and_lack_a_part(pcn: Path) -> None:
    whole = points(pcn / "train/complete/03761084/Microwave7n000000.pcd")
    tree, missing = cKDTree(whole), []
    for path in (pcn / "train/partial/03761084/Microwave7n000000").iterdir():
        seen = points(path)
        assert tree.query(seen)[0].max() < 0.03
        missing.append((cKDTree(seen).query(whole)[0] > 0.05).mean())
    assert min(missing) > 0.1, "no view shows the inside and the back"


def test_axes_are_those_of_shapenet(pcn: Path) -> None:
    ours = sample("Microwave", numbers=[0], seed=7, checked=False)
    whole = points(pcn / "train/complete/03761084/Microwave7n000000.pcd")
    extent = np.ptp(ours.points(16384).position[0], axis=0)
    assert np.ptp(whole, axis=0) == pytest.approx(extent[[1, 2, 0]] / np.linalg.norm(extent), abs=1e-5)
    handle = ours.batch.program.vocabularies["semantic"].index("door")
    front = whole[ours.points(16384).semantic[0] == handle]
    assert front[:, 2].mean() < -0.1, "the door is in front, at -z"


@pytest.mark.slow
def test_too_few_points_and_another_size_are_found_out(lay: Lay) -> None:
    folder = lay("pcn", "Laptop", n=1)
    path = folder / "train/partial/03642806/Laptop7n000000/03.pcd"
    seen = read_pcd(path)
    for spoilt, fault in (
        (seen[:1000], "fewer than 2048"),
        (2 * seen, "another frame or size"),
        (seen + 1e-4, "differ"),
    ):
        path.write_bytes(pcd_bytes(spoilt))
        assert any("03.pcd" in found and fault in found for found in unlike(folder)), fault
    path.write_bytes(path.read_bytes()[:-1])
    assert any("is not a binary PCD file" in found for found in unlike(folder))


def test_shapenet_55(lay: Lay) -> None:
    folder = lay("shapenet55", "Laptop", n=3, shares=(1, 1, 1))
    assert not faults(folder)
    for split in ("train", "test"):
        (name,) = (folder / f"ShapeNet-55/{split}.txt").read_text().split()
        tax, _, rest = name.partition("-")
        assert tax == "03642806" and "-" not in rest and rest.count(".") == 1
        cloud = np.load(folder / "shapenet_pc" / name)
        assert cloud.shape == (8192, 3) and cloud.dtype == np.float32


def test_what_shapenet_lacks_is_refused() -> None:
    for layout in ("pcn", "shapenet55"):
        with pytest.raises(UserError, match="ShapeNet has no class for Kettle") as refused:
            LAYOUTS[layout].term("Kettle")
        assert "the nearest is jar" in (refused.value.hint or "")

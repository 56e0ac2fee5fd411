"""Part poses: views read as GAPartNet's loader does, boxes of parts against the joints, faults that the reader finds."""

from __future__ import annotations

import pickletools
from pathlib import Path

import numpy as np
import pytest

from artipg_dsl import sample
from artipg_dsl.errors import UserError
from artipg_dsl.layouts.gapartnet.parts import CLASSES, gaparts
from artipg_dsl.layouts.gapartnet.points import similarity_error
from artipg_dsl.layouts.pth import pth_bytes, read_pth
from artipg_dsl.layouts.registry import LAYOUTS

from .conftest import Lay, faults, unlike


@pytest.fixture(scope="module")
def views(lay: Lay) -> Path:
    return lay("gapartnet", "StorageFurniture", n=1)


def test_views_are_what_the_loader_takes(views: Path) -> None:
    assert not faults(views)
    files = sorted((views / "GAPartNet_All/train/pth").iterdir())
    assert [path.stem for path in files] == [
        f"StorageFurniture_StorageFurniture7n000000_{view:02d}_{state:03d}" for view in (0, 1) for state in (0, 1)
    ]
    for path in files:
        assert path.name.split("_")[0] == "StorageFurniture"
        xyz, rgb, kind, instance, npcs, pixel = read_pth(path)
        assert xyz.shape == rgb.shape == npcs.shape == (20000, 3) and pixel.shape == (20000, 2)
        assert [a.dtype for a in (xyz, rgb, kind, instance, npcs, pixel)] == [
            np.dtype(t) for t in ("f4", "f4", "i4", "i4", "f4", "i4")
        ]
        assert all(a.flags.writeable for a in (xyz, npcs))
        assert np.linalg.norm(xyz, axis=1).max() == pytest.approx(1, abs=1e-5)
        assert 0 <= rgb.min() and rgb.max() <= 1 and 0 <= kind.min() and kind.max() <= 9
        shown = np.unique(instance[instance != -100])
        assert shown.tolist() == list(range(len(shown))) and len(shown) > 3
        assert np.abs(npcs).max() <= 0.5 and (npcs[instance == -100] == 0).all()
        for k in shown:
            part = npcs[instance == k].astype(np.float64)
            assert similarity_error(part, xyz[instance == k].astype(np.float64)) < 5e-3
        gt = np.loadtxt(views / "GAPartNet_All/train/gt" / f"{path.stem}.txt", dtype=int)
        assert ((gt == -100) == (instance == -100)).all() and (gt[gt >= 0] // 1000 == kind[gt >= 0]).all()
        radius, *center = np.loadtxt(views / "GAPartNet_All/train/meta" / f"{path.stem}.txt")
        assert (xyz * radius + center)[:, 2].min() > 0, "in front of the camera"
    assert all(
        (views / f"GAPartNet_All/{split}/pth").is_dir() for split in ("train", "val", "test_intra", "test_inter")
    )
    assert (views / "nopart.txt").read_text().split()


def test_handles_beside_a_lid_face_as_it_does() -> None:
    """The long handle of a pressure cooker's lid lies in the plane of its middle, a little above or below it."""
    term = LAYOUTS["gapartnet"].term("KitchenPot")
    assert term is not None
    found = 0
    for parts in gaparts(sample("KitchenPot", n=4, set={"kind": "pressure"}, checked=False).batch, term):
        (lid,) = (part for part in parts if CLASSES[part.kind] == "slider_lid")
        for part in (part for part in parts if part.link == lid.link and part.instance >= 0):
            found += 1
            assert part.axes[2] @ lid.axes[2] == pytest.approx(1)
    assert found >= 4


def test_the_box_of_a_round_button_is_as_long_as_wide() -> None:
    """Also of a button of a few millimetres, whose mesh has few corners by the tolerance that the boxes of doors are found with."""
    term = LAYOUTS["gapartnet"].term("Camera")
    assert term is not None
    parts = gaparts(sample("Camera", n=6, seed=0).batch, term)
    sizes = np.array([part.size for own in parts for part in own if CLASSES[part.kind] == "slider_button"])
    round_ones = sizes[sizes[:, 1] > 0.9 * sizes[:, 0]]
    assert len(round_ones) >= 3 and (round_ones[:, 1] > 0.995 * round_ones[:, 0]).all()


def test_categories_that_are_not_trained_on_are_inter(lay: Lay) -> None:
    """``on_validation_epoch_end`` takes the third of the lists of views, ``test_inter``."""
    folder = lay("gapartnet", "Laptop", n=1, shares=(0, 0, 1))
    held = {path.name: len(list((path / "pth").iterdir())) for path in (folder / "GAPartNet_All").iterdir()}
    assert held == {"train": 0, "val": 0, "test_intra": 0, "test_inter": 4}
    assert not faults(folder)


def test_files_name_nothing_that_older_readers_lack(views: Path) -> None:
    names = set()
    for path in list((views / "GAPartNet_All/train/pth").iterdir())[:1]:
        with path.open("rb") as stream:
            for _ in range(5):
                names |= {arg for op, arg, _ in pickletools.genops(stream) if op.name in ("GLOBAL", "STACK_GLOBAL")}
    assert names == {"numpy ndarray", "builtins bytearray"}


def test_torch_reads_them(views: Path) -> None:
    torch = pytest.importorskip(
        "torch", reason="torch is not installed; the files are read without it in the other tests"
    )
    path = next((views / "GAPartNet_All/train/pth").iterdir())
    for ours, theirs in zip(read_pth(path), torch.load(path, weights_only=False), strict=True):
        assert (ours == theirs).all()


@pytest.mark.parametrize("category", ["StorageFurniture", "Microwave", "Laptop", "Door"])
def test_boxes_stand_as_the_joints_say(category: str) -> None:
    """A door turns about x, which is its hinge, and y leads away from it; a drawer comes out along z."""
    objects = sample(category, n=2, seed=7, checked=False)
    term = LAYOUTS["gapartnet"].term(category)
    assert term is not None
    joints, seen = objects.joints(), set()
    for i, parts in enumerate(gaparts(objects.batch, term)):
        rows = {int(joints.child[j]): j for j in range(len(joints.owner)) if joints.owner[j] == i}
        for part in parts:
            name = CLASSES[part.kind]
            seen.add(name)
            assert part.axes @ part.axes.T == pytest.approx(np.eye(3), abs=1e-9)
            assert np.linalg.det(part.axes) == pytest.approx(1) and (part.size > 0).all()
            if part.instance >= 0:
                continue
            j = rows[part.link]
            opening = joints.axis[j] * (1 if (joints.high[j] or 0) >= -(joints.low[j] or 0) else -1)
            if name in ("hinge_door", "hinge_lid"):
                assert part.axes[0] @ opening == pytest.approx(1, abs=1e-6)
                assert (part.center - joints.origin[j]) @ part.axes[1] > 0.3 * part.size[1]
                assert np.cross(opening, part.axes[1]) @ part.axes[2] == pytest.approx(1, abs=1e-6), "opens along z"
                assert part.size[2] < part.size[1]
            elif name == "slider_drawer":
                assert part.axes[2] @ opening == pytest.approx(1, abs=1e-6) and part.size[0] >= part.size[1]
            elif name == "slider_button":
                assert part.axes[2] @ opening == pytest.approx(-1, abs=1e-6)
    assert seen & {"hinge_door", "hinge_lid"}


def test_traps_that_loaders_pass_over_are_found_out(lay: Lay) -> None:
    folder = lay("gapartnet", "Laptop", n=1)
    paths = sorted((folder / "GAPartNet_All/train/pth").iterdir())
    cases = {
        "a class that there is not": (2, lambda a: np.where(a > 0, 12, a).astype(np.int32)),
        "instances are not numbered": (3, lambda a: np.where(a >= 0, a + 1, a).astype(np.int32)),
        "coordinates beyond 0.5": (4, lambda a: a + np.float32(0.5)),
        "not its points moved and scaled": (4, lambda a: a * np.array([-1, 1, 1], np.float32)),
        "not at 1": (0, lambda a: a * np.float32(2)),
        "where readers need 20000": (None, lambda a: a[:19999]),
        "are float64": (0, lambda a: a.astype(np.float64)),
    }
    good = {path: read_pth(path) for path in paths}
    for first in range(0, len(cases), len(paths)):  # one in each file
        some = list(zip(list(cases.items())[first : first + len(paths)], paths, strict=False))
        for (_, (place, change)), path in some:
            path.write_bytes(pth_bytes([change(a) if place in (k, None) else a for k, a in enumerate(good[path])]))
        found = unlike(folder)
        for (fault, _), path in some:
            assert any(path.stem in line and fault in line for line in found), fault
    path.write_bytes(b"\x80\x04cos\nsystem\n")
    assert any("not a file of arrays" in found for found in unlike(folder))


def test_objects_and_parts_that_gapartnet_lacks_are_refused() -> None:
    with pytest.raises(UserError, match="GAPartNet has no class for Kettle") as refused:
        LAYOUTS["gapartnet"].term("Kettle")
    assert "the nearest is KitchenPot" in (refused.value.hint or "")
    with pytest.raises(UserError, match="there is no part `knob`"):
        LAYOUTS["gapartnet"].term("Kettle", {"Kettle": {"class": "KitchenPot", "parts": {"lid/prismatic": "knob"}}})
    with pytest.raises(UserError, match="no word of it is a part"):
        LAYOUTS["gapartnet"].term("Kettle", {"Kettle": {"class": "KitchenPot"}})

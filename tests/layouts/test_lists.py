"""A folder whose files are missing, or not as they were written, is not called whole: each of these is named, once."""

from pathlib import Path

import pytest

from .conftest import Lay, faults, unlike


@pytest.mark.parametrize(
    ("layout", "category", "names"),
    [
        ("shapenetpart", "Mug", ["synsetoffset2category.txt"]),
        ("partnet-seg", "Mug", ["stats/train_val_test_split/Mug.test.json"]),
        pytest.param(
            *("opd", "Microwave", ["annotations/MotionNet_valid.json", "annotations/OPDMulti_test.json", "valid.h5"]),
            marks=pytest.mark.slow,
        ),
    ],
)
def test_a_damaged_list_is_found(lay: Lay, layout: str, category: str, names: list[str]) -> None:
    folder = lay(layout, category, n=2)
    assert not faults(folder)
    for name in names:
        path = folder / name
        whole = path.read_bytes()
        path.unlink()
        assert f"{name}: the file is missing" in faults(folder)
        path.write_bytes(whole[: len(whole) // 2])
        assert [fault for fault in faults(folder) if fault.startswith(f"{name}: ")]
        path.write_bytes(whole)
    assert not faults(folder)


def test_files_that_lists_are_made_of_are_missed(lay: Lay) -> None:
    """They are read when another category is added, which then failed in a folder that had been called whole."""
    folder = lay("partnet-seg", "Mug", n=2)
    (folder / "objects/Mug-0.h5").unlink()
    assert [fault for fault in faults(folder) if "Mug-0.h5" in fault] == ["objects/Mug-0.h5: the file is missing"]


@pytest.mark.some
@pytest.mark.parametrize(
    ("layout", "category", "pattern"),
    [
        ("shapenetpart-h5", "Mug", "objects/*.h5"),
        ("shapenetpart-h5", "Mug", "hdf5_data/*train*.h5"),
        ("ancsh", "Laptop", "render/laptop/*/object.json"),
        ("ancsh", "Laptop", "urdf/laptop/*/none_motion.obj"),
        ("ditto", "Laptop", "Shape2Motion/*/scenes/*.npz"),
        ("pcn", "Mug", "PCN.json"),
        ("pcn", "Mug", ".layout/Mug.files"),
        ("pcn", "Mug", ".layout/lists"),
    ],
)
def test_whatever_is_damaged_is_named_once(lay: Lay, layout: str, category: str, pattern: str) -> None:
    """Also what no loader reads, and what is packed: bytes that change in the middle do not always stop a reader."""
    folder = lay(layout, category, n=1)
    path: Path = next(folder.glob(pattern))
    name, whole = str(path.relative_to(folder)), path.read_bytes()
    half = len(whole) // 2
    for left in (whole[:half], b"", whole[:half] + bytes([whole[half] ^ 0x5A]) + whole[half + 1 :], None):
        path.unlink() if left is None else path.write_bytes(left)
        found = faults(folder)
        assert [fault for fault in found if name in fault] == [
            fault for fault in found if fault.startswith(f"{name}: ")
        ]
        assert sum(name in fault for fault in found) == 1, left
        assert len(found) == 2 and found[1].startswith(f"{category}: is not compared with the model"), left
        path.write_bytes(whole)
    assert not faults(folder)


def test_a_category_without_its_record_was_not_finished(lay: Lay) -> None:
    """What is there of it may be read by loaders that take whatever is in a folder."""
    folder = lay("shapenet55", "Mug", "Bottle", n=1)
    (folder / ".layout/Mug.json").unlink()
    assert [fault for fault in faults(folder) if fault.startswith("Mug: was not finished")]
    lay("shapenet55", "Mug", n=1, folder=folder)
    assert not faults(folder)


@pytest.mark.slow
def test_a_folder_of_before_checksums_is_read(lay: Lay) -> None:
    folder = lay("ditto", "Laptop", n=1)
    assert not unlike(folder)
    path: Path = next(folder.glob("Shape2Motion/*/scenes/*.npz"))
    path.write_bytes(b"")
    assert [fault for fault in faults(folder) if fault.startswith("Laptop: cannot be read")]


@pytest.mark.parametrize("left", [0, 200])
def test_a_damaged_urdf_is_a_fault(lay: Lay, left: int) -> None:
    folder = lay("ancsh", "Laptop", n=1)
    path: Path = next(folder.glob("urdf/laptop/*/syn.urdf"))
    path.write_bytes(path.read_bytes()[:left])
    assert any("syn.urdf" in fault for fault in faults(folder))

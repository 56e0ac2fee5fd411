"""Lists of all categories: a folder whose lists are missing or say something else is not called whole."""

from pathlib import Path

import pytest

from .conftest import Lay, faults


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
    assert faults(folder) == ["objects/Mug-0.h5: the file is missing"]


@pytest.mark.parametrize("left", [0, 200])
def test_a_damaged_urdf_is_a_fault(lay: Lay, left: int) -> None:
    folder = lay("ancsh", "Laptop", n=1)
    path: Path = next(folder.glob("urdf/laptop/*/syn.urdf"))
    path.write_bytes(path.read_bytes()[:left])
    assert any("syn.urdf" in fault for fault in faults(folder))

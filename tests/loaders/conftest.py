"""Two small categories that know different words, and folders of their objects."""

from pathlib import Path

import pytest

import artipg_dsl as apg

_CHEST = Path(__file__).parents[1] / "cli" / "programs" / "chest.apg"


@pytest.fixture(scope="session")
def chest() -> Path:
    return _CHEST


@pytest.fixture(scope="session")
def box(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("programs") / "box.apg"
    text = _CHEST.read_text().replace("category Chest", "category Box")
    path.write_text(
        text.replace(
            "label affordance.push on lid", "label affordance.contain on trunk\n  label affordance.lift on lid"
        )
    )
    return path


@pytest.fixture(scope="session")
def folders(chest: Path, box: Path, tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    """Five chests, at rest and open, and three boxes at rest; two views of each."""
    into = tmp_path_factory.mktemp("folders")
    apg.sample(chest, n=5, seed=3).to(
        into / "chests", "points,views", points=64, states="rest,open", motion=True, views=2
    )
    apg.sample(box, n=3, seed=3).to(into / "boxes", "points,views", points=64, motion=True, views=2)
    return [into / "chests", into / "boxes"]

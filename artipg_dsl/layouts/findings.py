"""What a folder does not hold as it should: collected, not raised, so that all of it is reported at once."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from dataclasses import field
from pathlib import Path

import numpy as np

from ..records import dataclass


@dataclass(slots=True)
class Findings:
    """``faults``: (file, what is wrong with it); ``checked``: how many things were looked at."""

    faults: list[tuple[str, str]] = field(default_factory=list)
    checked: int = 0

    def of(self, place: str, holds: bool, otherwise: str) -> bool:
        """Whether something holds; if not, ``otherwise`` is reported."""
        self.checked += 1
        if not holds and (place, otherwise) not in self.faults:
            self.faults.append((place, otherwise))
        return bool(holds)

    def near(self, place: str, what: str, read: np.ndarray, model: np.ndarray, tolerance: float) -> bool:
        """Whether numbers are those of the model."""
        if not self.of(
            place, np.shape(read) == np.shape(model), f"{what}: {np.shape(read)} instead of {np.shape(model)}"
        ):
            return False
        off = float(np.abs(np.asarray(read, dtype=np.float64) - model).max()) if np.size(model) else 0.0
        return self.of(place, off <= tolerance, f"{what} differ from the model by up to {off:.3g}")

    def same(self, place: str, what: str, read: np.ndarray, model: np.ndarray) -> bool:
        """Whether whole numbers are those of the model."""
        if not self.of(
            place, np.shape(read) == np.shape(model), f"{what}: {np.shape(read)} instead of {np.shape(model)}"
        ):
            return False
        wrong = int((np.asarray(read) != model).sum())
        return self.of(place, not wrong, f"{wrong} {what} differ from the model")


def read_table(path: Path, kind: type[np.generic]) -> np.ndarray:
    """Numbers of a text. Raises ValueError, which names it."""
    try:
        return np.loadtxt(path, dtype=kind)
    except ValueError as wrong:
        raise ValueError(f"{path}: {wrong}") from None


def read_xml(path: Path) -> ET.Element:
    """The root of a text in XML. Raises OSError, ValueError, which names it."""
    try:
        return ET.parse(path).getroot()
    except ET.ParseError as wrong:
        raise ValueError(f"{path}: {wrong}") from None


def read_vertices(path: Path) -> np.ndarray:
    """The vertices (n, 3) of an OBJ. Raises ValueError."""
    rows = [line.split()[1:4] for line in path.read_text("utf-8").splitlines() if line.startswith("v ")]
    return np.array(rows, dtype=np.float64).reshape(-1, 3)

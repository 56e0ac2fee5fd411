"""Render the pictures of the gallery anew: a sheet of 30 objects for each category, and two of each in one picture.

python docs/gallery/make.py [NAME ...]      needs Pillow, which shrinks the files
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

import numpy as np
from PIL import Image

from artipg_dsl.session import Session, categories
from artipg_dsl.view.sheet import write_sheet

HERE = Path(__file__).parent
TILE, COLUMNS = 170, 11
#: which objects stand for their category, the second of them with its joints opened
SHOWN = {
    "Faucet": (22, 26),
    "Foldingrack": (6, 12),
    "Bottle": (14, 4),
    "Chair": (18, 23),
    "Scissors": (4, 13),
    "USB": (7, 15),
    "Window": (8, 3),
    "Mug": (7, 11),
    "Table": (12, 29),
}


def picture(name: str, numbers: np.ndarray, tile: int, columns: int) -> Image.Image:
    batch = Session.of(name).sampler.batch(numbers, 1, checked=True)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "sheet.png"
        write_sheet(batch, path, colour="material", tile=tile, columns=columns)
        return Image.open(path).convert("RGB")


def save(image: Image.Image, path: Path) -> None:
    colours = image.quantize(256)
    image.quantize(palette=colours, dither=Image.Dither.FLOYDSTEINBERG).save(path, optimize=True)


def together(names: list[str]) -> Image.Image:
    """Two objects of each category, one above the other."""
    pairs = [picture(name, np.array(SHOWN.get(name, (6, 13))), TILE, 1) for name in names]
    high = pairs[0].height
    whole = Image.new("RGB", (TILE * COLUMNS, high * -(-len(pairs) // COLUMNS)), "white")
    for k, pair in enumerate(pairs):
        whole.paste(pair, (TILE * (k % COLUMNS), high * (k // COLUMNS)))
    return whole


def main(names: list[str]) -> None:
    shipped = categories()
    for name in names or shipped:
        if shipped[name].stem != "microwave":  # its picture shows doors closed and open
            save(picture(name, np.arange(30), 160, 6), HERE / f"{shipped[name].stem}.png")
    save(together(list(shipped)), HERE / "categories.png")


if __name__ == "__main__":
    main(sys.argv[1:])

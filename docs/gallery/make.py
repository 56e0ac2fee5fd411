"""Render the pictures of the gallery anew: a sheet of 30 objects for each category, and two of each in one picture.

python docs/gallery/make.py [NAME ...]      needs Pillow, which shrinks the files

With names the others keep their place in the picture of all: the file says which it shows.
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

import numpy as np
from PIL import Image, PngImagePlugin

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
    "Ruler": (28, 21),
    "Fan": (3, 19),
}


def picture(name: str, numbers: np.ndarray, tile: int, columns: int) -> Image.Image:
    batch = Session.of(name).sampler.batch(numbers, 1, checked=True)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "sheet.png"
        write_sheet(batch, path, colour="material", tile=tile, columns=columns)
        return Image.open(path).convert("RGB")


def save(image: Image.Image, path: Path, shows: list[str] | None = None) -> None:
    colours = image.quantize(256)
    info = PngImagePlugin.PngInfo()
    if shows:
        info.add_text("shows", " ".join(shows))
    image.quantize(palette=colours, dither=Image.Dither.FLOYDSTEINBERG).save(path, optimize=True, pnginfo=info)


def drawn(path: Path) -> dict[str, Image.Image]:
    """The pairs of a picture of all that is there."""
    if not path.exists():
        return {}
    whole = Image.open(path)
    names = str(whole.info.get("shows", "")).split()
    high = whole.height // max(-(-len(names) // COLUMNS), 1)
    corners = [(TILE * (k % COLUMNS), high * (k // COLUMNS)) for k in range(len(names))]
    colours = whole.convert("RGB")
    return {name: colours.crop((x, y, x + TILE, y + high)) for name, (x, y) in zip(names, corners, strict=True)}


def together(names: list[str], known: dict[str, Image.Image]) -> Image.Image:
    """Two objects of each category, one above the other."""
    pairs = [known.get(name) or picture(name, np.array(SHOWN.get(name, (6, 13))), TILE, 1) for name in names]
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
    known = {name: pair for name, pair in drawn(HERE / "categories.png").items() if name not in names} if names else {}
    save(together(list(shipped), known), HERE / "categories.png", list(shipped))


if __name__ == "__main__":
    main(sys.argv[1:])

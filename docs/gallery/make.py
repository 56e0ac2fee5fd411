"""Render the pictures of the gallery anew: a sheet of 30 objects for each category, and two of each in one picture.

python docs/gallery/make.py [NAME ...]      names of categories or of OTHERS

Needs Pillow, which writes WebP: a seventh of the size of PNG, with all colours.

With names the others keep their place in the picture of all, which is lossless for that: the file says which it shows.
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

import numpy as np
from PIL import Image

from artipg_dsl.diagnostics import did_you_mean
from artipg_dsl.session import Session, categories
from artipg_dsl.view.sheet import Sheet, write_sheet

HERE = Path(__file__).parent
TILE, COLUMNS = 170, 11
DESCRIPTION = 0x010E  # the field of EXIF for words
#: which objects stand for their category, the second of them with its joints opened
SHOWN = {
    "Faucet": (22, 26),
    "Foldingrack": (6, 12),
    "Bottle": (14, 4),
    "Chair": (18, 17),
    "Scissors": (4, 13),
    "USB": (7, 15),
    "Window": (8, 3),
    "Mug": (7, 11),
    "Table": (12, 29),
    "Ruler": (28, 21),
    "Fan": (3, 19),
}
#: pictures of other pages: what they show, of which objects and seed, colours, pixels and columns
SHAPES = (
    0,
    1,
    3,
    5,
    6,
    7,
    9,
    10,
    11,
    13,
    14,
    15,
    17,
    19,
    20,
    25,
    27,
    29,
    32,
    36,
    37,
    49,
    52,
    53,
    58,
    60,
    62,
    63,
    67,
    71,
    72,
    79,
    124,
    125,
)
OTHERS: dict[str, tuple[str, tuple[int, ...], int, str, int, int]] = {
    "microwave": ("Microwave", tuple(range(10)), 7, "material", 192, 5),
    "microwave-parts": ("Microwave", tuple(range(10)), 7, "part", 192, 5),
    "desk_lamp": (str(HERE / "desk_lamp.apg"), tuple(range(12)), 0, "material", 160, 6),
    "corkscrew": (str(HERE / "corkscrew.apg"), tuple(range(6)), 0, "material", 160, 6),
    "cymbal_stand": (str(HERE / "cymbal_stand.apg"), tuple(range(6)), 0, "material", 160, 6),
    "arm_lamp": (str(HERE / "arm_lamp.apg"), tuple(range(6)), 0, "material", 160, 6),
    "scissor_jack": (str(HERE / "scissor_jack.apg"), tuple(range(6)), 0, "material", 160, 6),
    "venetian_blind": (str(HERE / "venetian_blind.apg"), tuple(range(6)), 0, "material", 160, 6),
    "primitives": (str(HERE / "shapes.apg"), SHAPES, 0, "part", 96, 7),
}


def picture(
    name: str, numbers: np.ndarray, tile: int, columns: int, seed: int = 1, colour: str = "material"
) -> Image.Image:
    batch = Session.of(name).sampler.batch(numbers, seed, checked=True)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "sheet.png"
        write_sheet(batch, path, Sheet(columns, tile, colour))
        return Image.open(path).convert("RGB")


def save(image: Image.Image, path: Path) -> None:
    image.save(path, quality=90, method=6)


def save_together(image: Image.Image, path: Path, shows: list[str]) -> None:
    info = Image.Exif()
    info[DESCRIPTION] = " ".join(shows)
    image.save(path, lossless=True, method=6, exif=info)


def drawn(path: Path) -> dict[str, Image.Image]:
    """The pairs of a picture of all that is there."""
    if not path.exists():
        return {}
    whole = Image.open(path)
    names = str(whole.getexif().get(DESCRIPTION, "")).split()
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
    for name in names:
        if name not in shipped and name not in OTHERS:
            sys.exit(f"there is no {name}: {did_you_mean(name, [*shipped, *OTHERS]) or 'give names such as Chair'}")
    for name in [name for name in names or OTHERS if name in OTHERS]:
        what, numbers, seed, colour, tile, columns = OTHERS[name]
        save(picture(what, np.array(numbers), tile, columns, seed, colour), HERE / f"{name}.webp")
    names, every = [name for name in names if name not in OTHERS], not names
    if not names and not every:
        return
    for name in names or shipped:
        if shipped[name].stem not in OTHERS:
            save(picture(name, np.arange(30), 160, 6), HERE / f"{shipped[name].stem}.webp")
    known = {name: pair for name, pair in drawn(HERE / "categories.webp").items() if name not in names} if names else {}
    save_together(together(list(shipped), known), HERE / "categories.webp", list(shipped))


if __name__ == "__main__":
    main(sys.argv[1:])

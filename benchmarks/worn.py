"""Real objects fitted, bound and worn by mutants: the table of figures in docs/details.md, and the sheets of docs/real.md.

    python benchmarks/worn.py FOLDER OUT [Chair ...]           # every category with a folder of its own below FOLDER
    python benchmarks/worn.py FOLDER OUT --sheets docs/gallery/real

OUT holds what is fitted and bound; what is there already is not done again. Sheets are WebP, for which Pillow is needed.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
from pathlib import Path
from typing import Any

from details import surfaces
from structure import NAMES

from artipg_dsl.session import categories

SHOWN = "cpa", "dpa,cpa", "apa,dpa,cpa"  # mutants, two each


def make(*words: object) -> None:
    """Run a command of ours to its end."""
    done = subprocess.run([sys.executable, "-m", "artipg_dsl", *map(str, words)], capture_output=True, text=True)
    if done.returncode:
        print(f"apgc {' '.join(map(str, words))}: {done.stderr.strip()}", file=sys.stderr, flush=True)


def fitted_and_bound(category: str, folder: Path, out: Path) -> tuple[Path, Path]:
    fitted, bound = out / category / "fitted", out / category / "bound"
    make("fit", category, folder / NAMES.get(category, category), "-o", fitted)
    make("bind", fitted, "-o", bound)
    return fitted, bound


def rows(category: str, fitted: Path, bound: Path) -> list[str]:
    """The lines of the table, one for each object that was bound."""
    fits = {one["name"]: one for one in json.loads((fitted / "fit.json").read_text())["objects"]}
    return [
        line(f"{category}, {called(one['name'])}", fits[one["name"]]["distance"], one)
        for one in json.loads((bound / "bind.json").read_text())["objects"]
    ]


def called(name: str) -> str:
    """What a sample is called, without whose it is."""
    return name.removesuffix("-object").split("_", 2 if name.startswith("SH3D") else 1)[-1]


def line(name: str, off: float, told: dict[str, Any]) -> str:
    cells = [", ".join(f"{told[k][way]:.2f}" for k in ("before", "after", "floor")) for way in ("to_real", "to_worn")]
    covered = ", ".join(f"{100 * told['after'][way]:.0f} %" for way in ("covered_real", "covered_worn"))
    torn = " | ".join(f"{100 * told[k]:.1f} %" for k in ("torn", "inverted"))
    return f"| {name} | {off:.2f} | {cells[0]} | {cells[1]} | {covered} | {torn} |"


def save_sheet(png: Path, webp: Path) -> None:
    """Half as large: tiles of 150 pixels."""
    from PIL import Image

    with Image.open(png) as image:
        image.convert("RGB").reduce(2).save(webp, quality=88, method=6)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("out", type=Path)
    parser.add_argument("categories", nargs="*")
    parser.add_argument("--sheets", type=Path, help="where the sheets go")
    asked = parser.parse_args()
    shipped = categories()
    for category in asked.categories or [name for name in shipped if (asked.folder / NAMES.get(name, name)).is_dir()]:
        fitted, bound = fitted_and_bound(category, asked.folder, asked.out)
        if not (bound / "bind.json").exists():
            continue
        print("\n".join(rows(category, fitted, bound)), flush=True)
        sheet = asked.out / category / "sheet.png"
        surfaces([(fitted, bound)], sheet, list(SHOWN), 2)
        if asked.sheets is not None:
            save_sheet(sheet, asked.sheets / f"{shipped[category].stem}.webp")


if __name__ == "__main__":
    main()

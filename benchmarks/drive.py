"""Exported files under somebody else's controllers: ``python benchmarks/drive.py [-n OBJECTS] [--most JOINTS] [CATEGORY ...]``.

The drivers (``tests/simulators/strangers``) know the files alone. Each joint that is limited and follows no other is driven to
both ends of its range; an object passes where all of them come within 2 % of their range and what follows has followed
within one degree or 2 mm. Every failure is reported, then a table: objects that passed by category and driver.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).parents[1]
sys.path[:0] = [str(ROOT / "tests")]

from simulators.strangers.ways import WAYS, Way  # noqa: E402

from artipg_dsl.session import categories  # noqa: E402


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("categories", nargs="*", default=categories())
    parser.add_argument("-n", type=int, default=2, help="objects of each category")
    parser.add_argument("--most", type=int, help="joints of an object, evenly chosen; all unless given")
    parser.add_argument("--seed", type=int, default=11)
    parser.add_argument("--way", action="append", choices=list(WAYS), help="this driver alone (repeatable)")
    parser.add_argument(
        "--folder", type=Path, help="objects that are there already: a folder of folders of each category"
    )
    arguments = parser.parse_args()
    ways = [WAYS[name] for name in arguments.way or WAYS]
    print("\n".join(f"{way.package} is not installed: without {way.name}" for way in ways if not way.there))
    ways = [way for way in ways if way.there]
    rows, seconds = [], dict.fromkeys((way.name for way in ways), 0.0)
    with tempfile.TemporaryDirectory() as place:
        for category in arguments.categories:
            folder = arguments.folder or Path(place)
            if arguments.folder is None:
                _export(category, folder / category, arguments.n, arguments.seed)
            objects = sorted((folder / category / "objects").iterdir())[: arguments.n]
            cells = []
            for way in ways:
                begun = time.perf_counter()
                passed = sum([_passed(way, category, one, arguments.most) for one in objects])
                seconds[way.name] += time.perf_counter() - begun
                cells.append(f"{passed} of {len(objects)}")
            rows.append(f"| {category} | {' | '.join(cells)} |")
    print(f"\n| category | {' | '.join(way.name for way in ways)} |\n|---|{'---:|' * len(ways)}", *rows, sep="\n")
    print(f"| seconds | {' | '.join(f'{taken:.0f}' for taken in seconds.values())} |")


def _export(category: str, folder: Path, count: int, seed: int) -> None:
    sample = [sys.executable, "-m", "artipg_dsl", "sample", category]
    options = ["-n", str(count), "--seed", str(seed), "--format", "urdf,mjcf", "-o", str(folder)]
    subprocess.run([*sample, *options], check=True, stdout=subprocess.DEVNULL)


def _passed(way: Way, category: str, folder: Path, most: int | None) -> bool:
    try:
        moves = way.drive(folder, most)
    except Exception as error:  # a simulator's own kind, whichever it is
        print(f"{category} {folder.name} {way.name}: {type(error).__name__}: {error}", flush=True)
        return False
    failed = [move for move in moves if not (move.reached and move.followed)]
    for move in failed:
        print(f"{category} {folder.name} {way.name}: {move}", flush=True)
    return not failed


if __name__ == "__main__":
    main()

"""How much of the discrete structure of real objects `apgc fit` gets right: counts of drawers, doors and legs, kinds of handles, what is there.

    python benchmarks/structure.py FOLDER                      # all objects of structure.json, below FOLDER
    python benchmarks/structure.py FOLDER Door TrashCan        # those of some categories
    python benchmarks/structure.py FOLDER --json found.json    # and what was found, to look at

`structure.json` says what is right, and how this was made. An object is right if all of its facts are. Categories of which it says
nothing are fitted, too, where they are named. The distances are those of `fitting.py`.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any

import numpy as np
from fitting import real

from artipg_dsl.fit.pose import Frame

TRUTH = Path(__file__).with_name("structure.json")
NAMES = {
    "TrashCan": "Trashcan",
    "WashingMachine": "Washingmachine",
}  # of folders, where they are not those of categories
Facts = dict[str, list[Any]]


def found(values: dict[str, Any], name: str, counted: dict[str, Any]) -> list[Any]:
    """What a fit says of a fact: a value for each element of what repeats."""
    if name in counted:
        return [sum(_worth(each, worth) for draw, worth in counted[name].items() for each in _all(values, draw))]
    return _all(values, name) or ["none"]


def _all(values: dict[str, Any], name: str) -> list[Any]:
    value = values.get(name, [])
    return value if isinstance(value, list) else [value]


def _worth(value: Any, worth: dict[str, int] | int) -> int:
    return worth.get(value, 0) if isinstance(worth, dict) else worth * value


def wrong(values: dict[str, Any], facts: Facts, counted: dict[str, Any]) -> dict[str, list[Any]]:
    """The facts that a fit has wrong, each with what it says instead."""
    said = {name: found(values, name, counted) for name in facts}
    return {name: said[name] for name, right in facts.items() if not all(value in right for value in said[name])}


def share(right: int, of: int) -> str:
    return f"{right} of {of}" if of else "-"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("categories", nargs="*")
    parser.add_argument("--json", type=Path)
    asked = parser.parse_args()
    truth = json.loads(TRUTH.read_text())
    truth.pop("about")
    counted = truth.pop("counted")
    rows, kept, distances, times = [], {}, [], []
    for category in asked.categories or truth:
        cases, seconds = real(asked.folder, category, NAMES.get(category, category), Frame())
        right, of, whole = 0, 0, 0
        for case in cases:
            facts = truth.get(category, {}).get(case.name, {})
            missed = wrong(case.values, facts, counted.get(category, {}))
            right, of, whole = right + len(facts) - len(missed), of + len(facts), whole + (not missed)
            print(f"{category} {case.name}: {case.distance:.2f} % off, {case.verdict}", flush=True)
            for name, said in missed.items():
                print(f"    {name} is {', '.join(map(str, said))}; right: {facts[name]}", flush=True)
        rows.append((category, cases, seconds, right, of, whole if of else 0, len(cases) if of else 0))
        kept[category] = [case.values for case in cases]
        distances += [(case.distance, case.boxes) for case in cases]
        times += [seconds] * len(cases)
    print("\n| category | objects | distance | boxes | CPU seconds | facts right | objects all right |")
    print("|---|---|---|---|---|---|---|")
    for category, cases, seconds, right, of, whole, judged in rows:
        near = ", ".join(f"{case.distance:.2f}" for case in cases)
        boxes = ", ".join(f"{case.boxes:.2f}" for case in cases)
        told = f"{seconds:.1f} | {share(right, of)} | {share(whole, judged)}"
        print(f"| {category} | {len(cases)} | {near} | {boxes} | {told} |")
    off, off_of_boxes = np.median(distances, axis=0)
    right, of, whole, judged = (sum(row[k] for row in rows) for k in (3, 4, 5, 6))
    told = f"{np.median(times):.1f} | **{share(right, of)}** | **{share(whole, judged)}**"
    print(f"| **all, medians** | {len(times)} | **{off:.2f}** | **{off_of_boxes:.2f}** | {told} |")
    if asked.json:
        asked.json.write_text(json.dumps(kept, indent=1) + "\n")


if __name__ == "__main__":
    main()

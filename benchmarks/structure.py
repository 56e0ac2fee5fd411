"""How much of the discrete structure of real objects `apgc fit` gets right: counts of drawers, doors and legs, kinds of handles, what is there.

    python benchmarks/structure.py FOLDER                      # all objects of structure.json, below FOLDER
    python benchmarks/structure.py FOLDER Door TrashCan        # those of some categories
    python benchmarks/structure.py FOLDER --json found.json    # and what was found, to look at

`structure.json` says what is right, and how this was made. An object is right if all of its facts are.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any

from fitting import Case, real

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
    return f"{right} of {of} ({100 * right / max(of, 1):.0f} %)"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("categories", nargs="*")
    parser.add_argument("--json", type=Path)
    asked = parser.parse_args()
    truth = json.loads(TRUTH.read_text())
    truth.pop("about")
    counted = truth.pop("counted")
    rows: list[tuple[int, int, bool]] = []
    kept: dict[str, list[Case]] = {}
    for category in asked.categories or truth:
        cases, _ = real(asked.folder, category, NAMES.get(category, category), Frame())
        kept[category] = cases
        missed = [wrong(case.values, truth[category][case.name], counted.get(category, {})) for case in cases]
        own = [
            (len(truth[category][c.name]) - len(bad), len(truth[category][c.name]), not bad)
            for c, bad in zip(cases, missed, strict=True)
        ]
        rows += own
        print(
            f"{category:<17} facts {share(sum(r[0] for r in own), sum(r[1] for r in own))}, objects {share(sum(r[2] for r in own), len(own))}"
        )
        for case, bad in zip(cases, missed, strict=True):
            for name, said in bad.items():
                print(
                    f"    {case.name}: {name} is {', '.join(map(str, said))}; right: {truth[category][case.name][name]}",
                    flush=True,
                )
    print(
        f"all: facts {share(sum(r[0] for r in rows), sum(r[1] for r in rows))}, objects {share(sum(r[2] for r in rows), len(rows))}"
    )
    if asked.json:
        asked.json.write_text(
            json.dumps({name: [case.values for case in cases] for name, cases in kept.items()}, indent=1) + "\n"
        )


if __name__ == "__main__":
    main()

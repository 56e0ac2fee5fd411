"""How much of the discrete structure of real objects `apgc fit` gets right: counts of drawers, doors and legs, kinds of handles, what is there.

    python benchmarks/structure.py FOLDER                      # all objects of structure.json, below FOLDER
    python benchmarks/structure.py FOLDER Door TrashCan        # those of some categories
    python benchmarks/structure.py FOLDER --json found.json    # and what was found, to look at
    python benchmarks/structure.py FOLDER --tell               # what is wrong is said, as with `apgc fit --facts`, and fitted again

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

from artipg_dsl.fit.finding import find_files
from artipg_dsl.fit.pose import Frame
from artipg_dsl.fit.sources import File, Item
from artipg_dsl.graph.program import Program
from artipg_dsl.run.fitting import Asked, fit_all
from artipg_dsl.run.job import open_program

TRUTH = Path(__file__).with_name("structure.json")
NAMES = {
    "TrashCan": "Trashcan",
    "WashingMachine": "Washingmachine",
}  # of folders, where they are not those of categories
ROUNDS = 4  # in which what is wrong is said
Facts = dict[str, Any]


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


def entry(program: Program, name: str, right: list[Any]) -> Any:
    """What is said of a fact; None where no value of a draw says it."""
    draws = [draw for draw in program.draws if draw.column.name == name]
    options = [one for one in right if any(one in draw.options for draw in draws)]
    if draws and draws[0].kind == "choice":
        return " | ".join(options) or None
    numbers = [one for one in right if not isinstance(one, str)]
    return f"{min(numbers)} .. {max(numbers)}" if draws and numbers else None


def tell(folder: Path, category: str, truth: dict[str, Facts], counted: dict[str, Any]) -> list[list[Any]]:
    """Of each object: how many facts are right, of how many, how many of these were said, its distance; first of the fit without any."""
    sampler, source = open_program(category)
    files = find_files([str(folder / NAMES.get(category, category))])
    items = {file.parent.name: Item(file.parent.name, File(file)) for file in files if file.parent.name in truth}
    known: dict[str, Facts] = {name: {} for name in items}
    told, left = {name: [] for name in items}, dict(items)
    for _ in range(1 + ROUNDS):
        facts = {name: own for name, own in known.items() if own}
        for record in fit_all(sampler, Asked(source, Frame(), facts=facts), list(left.values())):
            name, off = record["name"], record["distance"]["both"]
            missed = wrong(record["drawn"], truth[name], counted)
            told[name].append(
                (len(truth[name]) - len(missed), len(truth[name]), len(known[name]), off, record["valid"])
            )
            said = {fact: entry(sampler.program, fact, truth[name][fact]) for fact in missed if fact not in counted}
            said = {fact: one for fact, one in said.items() if one is not None and fact not in known[name]}
            known[name] = {**known[name], **said}
            if not said:
                del left[name]
        if not left:
            break
    for name, rounds in told.items():
        shown = "; ".join(f"{right} of {of} at {off:.2f} %, {said} said" for right, of, said, off, _ in rounds)
        print(f"{category} {name}: {shown}  {json.dumps(known[name])}", flush=True)
    return list(told.values())


def tell_all(folder: Path, categories: list[str], truth: dict[str, Any], counted: dict[str, Any]) -> None:
    every = [
        one for category in categories for one in tell(folder, category, truth[category], counted.get(category, {}))
    ]
    for words, place in (("nothing said", 0), (f"after {ROUNDS} rounds at most", -1)):
        rounds = [one[place] for one in every]
        right, of, said = (sum(one[k] for one in rounds) for k in range(3))
        whole = sum(one[0] == one[1] for one in rounds)
        off, valid = np.median([one[3] for one in rounds]), sum(one[4] for one in rounds)
        print(
            f"{words}: {said} said, {right} of {of} right, {whole} of {len(rounds)} objects, {valid} valid, {off:.3f} % off"
        )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("categories", nargs="*")
    parser.add_argument("--json", type=Path)
    parser.add_argument("--tell", action="store_true")
    asked = parser.parse_args()
    truth = json.loads(TRUTH.read_text())
    truth.pop("about")
    counted = truth.pop("counted")
    if asked.tell:
        tell_all(asked.folder, asked.categories or list(truth), truth, counted)
        return
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

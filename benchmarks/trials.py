"""Trials of Where2Act on our own objects in SAPIEN: whether annotations foretell what a hand moves, and whether grasps hold.

    python benchmarks/trials.py [-n TRIALS] [--objects OBJECTS] [--each TRIALS] [--seed S] [-v] [CATEGORY ...]

``artipg_dsl/layouts/where2act/hand.py`` tells what a trial is and when it succeeds, ``forecast.py`` beside it what the annotations say; in
``tests/simulators``, ``attempts.py`` tells which are made, ``closing.py`` how a gripper closes. By category: of ``n`` random
trials how many come out as foretold and how many succeed, precision and recall of what was foretold for each primitive; of trials
that a label asks for, and of any others on the same links by the same primitives, how many succeed; how many grasps hold. ``-v``
lists what came out otherwise.
"""

from __future__ import annotations

import sys
from collections import Counter
from pathlib import Path

import numpy as np

sys.path[:0] = [str(Path(__file__).parents[1] / "tests")]

from objects import options_of  # noqa: E402
from simulators.attempts import PRIMITIVES, WORDS, Attempt, try_object  # noqa: E402
from simulators.closing import grips  # noqa: E402

from artipg_dsl.session import Session  # noqa: E402

CATEGORIES = (
    "Box Door Faucet Kettle Microwave Refrigerator StorageFurniture Switch TrashCan Window "
    "Bucket KitchenPot Safe Table WashingMachine"
)
"""Where2Act's: ten to train on, five to test on."""


def share(values: list[bool]) -> str:
    return f"{100 * sum(values) / len(values):.1f}" if values else "-"


def counted(values: list[bool]) -> str:
    return f"{sum(values)} of {len(values)}"


def row(name: str, found: list[Attempt], held: list[bool]) -> str:
    """One line of the table."""
    random = [a for a in found if not a.word]
    cells = [name, str(len(random)), share([a.foretold == a.came for a in random]), share([a.came for a in random])]
    for primitive in PRIMITIVES:
        own = [a for a in random if a.trial.primitive == primitive]
        cells.append(f"{share([a.came for a in own if a.foretold])} / {share([a.foretold for a in own if a.came])}")
    cells += [counted([a.came for a in found if a.word and a.labelled is value]) for value in (True, False)]
    return "| " + " | ".join([*cells, counted(held)]) + " |"


def main() -> None:
    parser = options_of(__doc__, "list trials that came out otherwise than foretold, and grasps that did not hold")
    parser.set_defaults(categories=CATEGORIES.split(), n=500)
    parser.add_argument("--objects", type=int, default=20, help="objects that the trials of a category are shared over")
    parser.add_argument("--each", type=int, default=1, help="trials of a word on a link")
    options = parser.parse_args()
    heads = ["category", "trials", "as foretold", "succeed", *(f"{p}: precision / recall" for p in PRIMITIVES)]
    print("| " + " | ".join([*heads, "labelled", "others of the link", "grasps hold"]) + " |")
    print("|---|" + "---:|" * (len(heads) + 2))
    for category in options.categories:
        sampler, found, gripped = Session.of(category).sampler, [], []
        for i in range(8 * options.objects):  # some have nothing that moves
            if i >= options.objects and sum(not a.word for a in found) >= options.n:
                break
            batch = sampler.batch(np.arange(i, i + 1), options.seed)
            found += try_object(batch, -(-options.n // options.objects), options.each, options.seed)
            gripped += grips(batch)
        print(row(category, found, [not one.fault for one in gripped]), flush=True)
        if options.v:
            for word in WORDS:
                own = [[a.came for a in found if a.word == word and a.labelled is value] for value in (True, False)]
                if own[0]:
                    print(f"    {word}: labelled {counted(own[0])}, others {counted(own[1])}")
            for a in found:
                if a.foretold != a.came or (a.labelled and not a.came):
                    kind = f"{a.word} " if a.labelled else ""
                    print(f"    {a.object} {kind}{a.trial.primitive} {a.link}: {a.fault or 'no fault'}; {a.note}")
            for what, count in Counter((g.name, g.link, g.fault) for g in gripped if g.fault).most_common():
                print(f"    grasp {what[0]} on {what[1]} {what[2]}: {count}")


if __name__ == "__main__":
    main()

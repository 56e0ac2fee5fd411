"""Whether a hand moves what labels say it moves: a bounded force on labelled points of exported objects, in MuJoCo.

    python benchmarks/affordances.py [-n OBJECTS] [--each POINTS] [--seed S] [-v] [CATEGORY ...]

For each category and word: points that bear it and were moved, of how many; and the same of points of the same links without it. What counts
as moved is told in ``tests/simulators/hands.py``. ``-v`` lists the points that were not.
"""

from __future__ import annotations

import sys
from pathlib import Path

sys.path[:0] = [str(Path(__file__).parents[1] / "tests")]

from objects import batches, options_of  # noqa: E402
from simulators.hands import WORDS, trials  # noqa: E402


def share(moved: list[bool]) -> str:
    return f"{sum(moved):5} of {len(moved):5} {100 * sum(moved) / len(moved):6.1f} %" if moved else f"{'-':>22}"


def main() -> None:
    parser = options_of(__doc__, "name the labelled points that do not move")
    parser.add_argument("--each", type=int, default=3, help="points of a word on a link")
    options = parser.parse_args()
    print(f"{'category':18}{'word':8}{'labelled':>22}{'others of the link':>24}")
    for category, batch in batches(options):
        found = trials(batch, each=options.each)
        for word in WORDS:
            held = [[t.moved for t in found if t.word == word and t.labelled is value] for value in (True, False)]
            if held[0]:
                print(f"{category:18}{word:8}{share(held[0])}  {share(held[1])}", flush=True)
        held = [[t.moved for t in found if t.labelled is value] for value in (True, False)]
        print(f"{category:18}{'all':8}{share(held[0])}  {share(held[1])}", flush=True)
        for t in found if options.v else ():
            if t.labelled and not t.moved:
                print(f"  object {t.object} {t.word} on {t.link} at {t.place} normal {t.normal}")


if __name__ == "__main__":
    main()

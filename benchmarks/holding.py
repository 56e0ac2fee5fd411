"""Whether a hand can hold what moves, and whether the grasps that are given hold: by exported meshes and code of its own.

    python benchmarks/holding.py [-n OBJECTS] [--seed S] [-v] [CATEGORY ...]

``tests/simulators/fingers.py`` tells what counts. Of the grasps that annotations give at rest for a hand of 8 cm, how many hold; of the
links that joints move and that two fingers can hold at all, how many have a grasp. ``-v`` names what has none and what does not hold.
"""

from __future__ import annotations

import sys
from collections import Counter
from pathlib import Path

sys.path[:0] = [str(Path(__file__).parents[1] / "tests")]

from objects import batches, options_of  # noqa: E402
from simulators.fingers import verdicts  # noqa: E402

from artipg_dsl.annotate.annotation import annotate  # noqa: E402


def main() -> None:
    options = options_of(__doc__, "name what has none, and what does not hold").parse_args()
    print(f"{'category':18}{'grasps that hold':>20}{'links with a grasp, of those that can be held':>50}")
    for category, batch in batches(options):
        held, links = verdicts(batch, annotate(batch))
        good, had = sum(not v.fault for v in held), sum(grasped for _, grasped in links)
        print(f"{category:18}{f'{good} of {len(held)}':>20}{f'{had} of {len(links)}':>50}", flush=True)
        if options.v:
            for name, count in Counter(name for name, grasped in links if not grasped).most_common():
                print(f"    none on {name}: {count}")
            for what, count in Counter((v.name, v.link, v.fault) for v in held if v.fault).most_common():
                print(f"    {what[0]} on {what[1]}: {what[2]}: {count}")


if __name__ == "__main__":
    main()

"""How many colliders objects have, and what they cost: the table of docs/formats.md.

For each category the convex pieces that validity was proved on, what is exported in place of them, and the CPU time that
this takes an object, one thread, for a shard of n objects.

    python benchmarks/colliders.py [-n 64] [Kettle ...]
"""

from __future__ import annotations

import argparse
import time

import numpy as np

from artipg_dsl.resources import categories_dir
from artipg_dsl.robot import solids
from artipg_dsl.robot.robots import Robots
from artipg_dsl.session import Session


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("categories", nargs="*", default=sorted(categories_dir().glob("*.apg")))
    options.add_argument("-n", type=int, default=64, help="objects of each category")
    options.add_argument("--seed", type=int, default=7)
    given = options.parse_args()
    print("| category | pieces, median | colliders, median | 90 % | most | ms per object |")
    print("|---|---:|---:|---:|---:|---:|")
    for name in given.categories:
        batch = Session.of(str(name)).sampler.batch(np.arange(given.n), given.seed)
        robots = Robots(batch)
        pieces = [len(items) for items in solids.group_by_object(robots.pieces, given.n)]
        begun = time.process_time()
        found = robots.colliders
        spent = (time.process_time() - begun) / given.n * 1e3
        counts = [len(hulls) for hulls in found]
        median, most = np.median(counts), max(counts)
        print(
            f"| {batch.program.name} | {np.median(pieces):.0f} | {median:.0f} | {np.percentile(counts, 90):.0f} | {most} | {spent:.0f} |",
            flush=True,
        )


if __name__ == "__main__":
    main()

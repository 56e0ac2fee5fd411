"""How fast each format of ``apgc export`` is written, and how large an object is.

All formats of one category in one run on the same objects, which are sampled before the clock starts: objects per second
of CPU time, one thread. The model of links and joints, which formats written together share, is measured apart. Files
go to a temporary folder, best one in memory (`TMPDIR=/dev/shm`): an ext4 without a journal takes half a millisecond for
a new file where many have been deleted within the last minutes, as here. Two tables: objects per second, then KiB and files of an object.

    python benchmarks/export_formats.py [-n 16] [Microwave ...]
"""

from __future__ import annotations

import argparse
import tempfile
import time
from pathlib import Path

import numpy as np

from artipg_dsl.export.objects import write_objects
from artipg_dsl.export.registry import FORMATS, object_formats
from artipg_dsl.resources import categories_dir
from artipg_dsl.robot.robots import Robots
from artipg_dsl.session import Session


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("categories", nargs="*", default=sorted(categories_dir().glob("*.apg")))
    options.add_argument("-n", type=int, default=16, help="objects of each category")
    given = options.parse_args()
    names, sizes = object_formats(), []
    print(f"| category | (the model) | {' | '.join(names)} |\n|---|{'---:|' * (len(names) + 1)}")
    for category in given.categories:
        batch = Session.of(str(category)).sampler.batch(np.arange(given.n), 7)
        with tempfile.TemporaryDirectory() as folder:  # what is computed once per program is not of interest
            write_objects(batch, Path(folder), [FORMATS[name] for name in names], only=batch.numbers[:1])
        begun = time.process_time()
        robots = Robots(batch)
        for i in range(given.n):
            robots.robot(i)
        row, size = [f"{given.n / (time.process_time() - begun):.0f}"], []
        for name in names:
            with tempfile.TemporaryDirectory() as folder:
                begun = time.process_time()
                write_objects(batch, Path(folder), [FORMATS[name]])
                row.append(f"{given.n / (time.process_time() - begun):.0f}")
                files = [path for path in Path(folder).rglob("*") if path.is_file()]
                bytes_each = sum(path.stat().st_size for path in files) / given.n
                size.append(f"{bytes_each / 1024:.0f} in {len(files) / given.n:.0f}")
        print(f"| {batch.program.name} | {' | '.join(row)} |", flush=True)
        sizes.append(f"| {batch.program.name} | {' | '.join(size)} |")
    print(f"\n| category | {' | '.join(names)} |\n|---|{'---:|' * len(names)}")
    print("\n".join(sizes))


if __name__ == "__main__":
    main()

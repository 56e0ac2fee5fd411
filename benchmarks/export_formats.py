"""How fast each format of ``apgc export`` is written, and how large an object is.

All formats of one category in one run on the same objects, which are sampled before the clock starts: objects per second
of CPU time, one thread. The model of links and joints, which formats written together share, is measured apart. Files
go to a temporary folder.

    python benchmarks/export_formats.py [-n 32] [Microwave ...]
"""

from __future__ import annotations

import argparse
import tempfile
import time
from pathlib import Path

import numpy as np

from artipg_dsl.export.chunk import write_objects
from artipg_dsl.export.registry import FORMATS, per_object
from artipg_dsl.export.robot import Robots
from artipg_dsl.session import Session


def main() -> None:
    options = argparse.ArgumentParser()
    options.add_argument("categories", nargs="*", default=["Microwave", "StorageFurniture", "Chair"])
    options.add_argument("-n", type=int, default=32, help="objects of each category")
    given = options.parse_args()
    print("| category | format | objects/s | files/object | KiB/object |\n|---|---|---:|---:|---:|")
    for name in given.categories:
        batch = Session.of(name).sampler.batch(np.arange(given.n), 7)
        with tempfile.TemporaryDirectory() as folder:  # what is computed once per program is not of interest
            write_objects(batch, Path(folder), [FORMATS["glb"]], only=batch.numbers[:1])
        begun = time.process_time()
        robots = Robots(batch)
        for i in range(given.n):
            robots.robot(i)
        print(f"| {name} | (the model alone) | {given.n / (time.process_time() - begun):.0f} | | |")
        for format_name in per_object():
            entry = FORMATS[format_name]
            with tempfile.TemporaryDirectory() as folder:
                begun = time.process_time()
                write_objects(batch, Path(folder), [entry])
                spent = time.process_time() - begun
                files = [path for path in Path(folder).rglob("*") if path.is_file()]
                size = sum(path.stat().st_size for path in files) / given.n / 1024
            print(
                f"| {name} | {format_name} | {given.n / spent:.0f} | {len(files) / given.n:.1f} | {size:.0f} |",
                flush=True,
            )


if __name__ == "__main__":
    main()

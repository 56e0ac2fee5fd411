"""What benchmarks over the objects of categories share: their options, and the batches to look at."""

from __future__ import annotations

import argparse
from collections.abc import Iterator

import numpy as np

from artipg_dsl.runtime.batch import Batch
from artipg_dsl.session import Session, categories


def options_of(doc: str | None, verbose: str) -> argparse.ArgumentParser:
    """The categories, how many objects of each, their seed, and ``-v``; ``verbose`` says what it lists."""
    parser = argparse.ArgumentParser(description=doc, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("categories", nargs="*", default=categories())
    parser.add_argument("-n", type=int, default=10, help="objects of each category")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("-v", action="store_true", help=verbose)
    return parser


def batches(options: argparse.Namespace) -> Iterator[tuple[str, Batch]]:
    """Each category with its first objects, whether they are valid or not."""
    for category in options.categories:
        yield category, Session.of(category).sampler.batch(np.arange(options.n), options.seed)

"""An object is the same alone, in any batch, in any order and in any process."""

import hashlib
import subprocess
import sys

import numpy as np
import pytest

from artipg_dsl import random
from artipg_dsl.geometry import points


def rows_of(batch, index):
    """Every value of one object of a batch, as bytes by site, joint and draw."""
    found = {}
    for table in batch.sites():
        at = table.owner == index
        cells = [
            *table.params.values(),
            table.rotation,
            table.translation,
            table.mirror,
            table.link,
            table.instance,
            table.semantic,
        ]
        found[f"site {table.number}"] = b"".join(np.ascontiguousarray(c[at]).tobytes() for c in cells)
    joints = batch.joints()
    at = joints.owner == index
    cells = [
        joints.number,
        joints.parent,
        joints.child,
        joints.origin,
        joints.axis,
        joints.low,
        joints.high,
        joints.rest,
        joints.mimic,
    ]
    found["joints"] = b"".join(np.ascontiguousarray(c[at]).tobytes() for c in cells)
    found["drawn"] = repr(batch.drawn(index)).encode()
    return found


def test_an_object_is_the_same_alone_and_in_any_batch(microwave):
    alone = rows_of(microwave.batch(np.array([37]), seed=7), 0)
    assert alone == rows_of(microwave.batch(np.arange(38), seed=7), 37)
    assert alone == rows_of(microwave.batch(np.arange(1000), seed=7), 37)
    assert alone == rows_of(microwave.batch(np.array([99, 37, 4]), seed=7), 1)


def test_points_are_the_same_alone_and_in_any_batch(microwave):
    def points_of(numbers, index):
        batch = microwave.batch(np.array(numbers), seed=7)
        made = points.sample(batch.sites(), len(batch), 512, random.key(7, "points"), batch.numbers.astype(np.uint64))
        return (
            made.position[index].tobytes(),
            made.normal[index].tobytes(),
            made.u[index].tobytes(),
            made.site[index].tobytes(),
        )

    assert points_of([37], 0) == points_of(range(30, 60), 7)


def test_seeds_and_numbers_give_different_objects(microwave):
    first = microwave.batch(np.arange(50), seed=1).values()["width"]
    second = microwave.batch(np.arange(50), seed=2).values()["width"]
    assert len(set(first.tolist())) == 50
    assert not np.intersect1d(first, second).size


SCRIPT = """
import hashlib, numpy as np
from artipg_dsl.session import Session
batch = Session.of("Microwave").sampler.batch(np.arange(20), seed=3)
digest = hashlib.sha256()
for table in batch.sites():
    digest.update(table.translation.tobytes() + table.link.tobytes())
digest.update(batch.program.hash.encode() + "".join(batch.links().name).encode())
print(digest.hexdigest())
"""


@pytest.mark.slow
@pytest.mark.parametrize("first, second", [("0", "1")])
def test_the_hash_seed_of_the_process_does_not_matter(first, second):
    def run(hash_seed):
        environment = {**__import__("os").environ, "PYTHONHASHSEED": hash_seed}
        done = subprocess.run(
            [sys.executable, "-c", SCRIPT], env=environment, capture_output=True, text=True, check=True
        )
        return done.stdout.strip()

    assert run(first) == run(second)
    assert len(run(first)) == len(hashlib.sha256().hexdigest())

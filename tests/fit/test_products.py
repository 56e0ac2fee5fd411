"""Products of matrices: the same whatever threads BLAS has."""

from __future__ import annotations

import os
import subprocess
import sys

import numpy as np
import pytest

from artipg_dsl.fit.products import at_a_time, crossed

_DIGEST = """
import numpy as np
from hashlib import blake2b
from artipg_dsl.fit.products import crossed

chance, told = np.random.default_rng(0), blake2b()
for count in (44, 60, 84):
    left, right = chance.random((2, count, 1024))
    told.update(CROSSED.tobytes())
print(told.hexdigest())
"""


@pytest.mark.parametrize("shape", [(3, 5, 7), (84, 84, 1000), (600, 600, 3)])
def test_pieces_make_the_whole(shape: tuple[int, int, int]) -> None:
    chance = np.random.default_rng(1)
    left, right = chance.random((shape[0], shape[2])), chance.random((shape[1], shape[2]))
    assert np.allclose(crossed(left, right), left @ right.T, rtol=1e-12)


def test_a_piece_is_never_empty() -> None:
    assert at_a_time(0) > at_a_time(1000) > at_a_time(10**9) == 1


def test_threads_do_not_round_otherwise() -> None:
    def digest(threads: int, product: str) -> str:
        text = _DIGEST.replace("CROSSED", product)
        env = {**os.environ, "OPENBLAS_NUM_THREADS": str(threads)}
        return subprocess.run([sys.executable, "-c", text], env=env, capture_output=True, text=True, check=True).stdout

    assert digest(1, "crossed(left, right)") == digest(4, "crossed(left, right)")

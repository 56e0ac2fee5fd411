"""Whether there can be a compiled backend, and arrays compared by their bits."""

import numpy as np
import pytest

from artipg_dsl.native import compiler

needs_compiler = pytest.mark.skipif(
    not compiler.compilers(), reason="there is no C compiler, and so no compiled backend: NumPy is used"
)


def bits(value) -> bytes:
    array = np.ascontiguousarray(value)
    return array.dtype.str.encode() + array.tobytes()

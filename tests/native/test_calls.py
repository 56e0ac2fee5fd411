"""What is handed to compiled code: arrays that it can read, or an error."""

from __future__ import annotations

import numpy as np
import pytest

from artipg_dsl.native.calls import address, call


@pytest.mark.parametrize(
    "array",
    [np.zeros(4, dtype=np.float32), np.zeros((4, 4))[:, ::2], np.zeros((2, 3)).T],
    ids=["single", "strided", "transposed"],
)
def test_arrays_that_code_would_misread_are_refused(array: np.ndarray) -> None:
    asked: list[object] = []
    with pytest.raises(TypeError, match="compiled code takes float64 row by row"):
        call(lambda *values: asked.extend(values), np.zeros(4), array)
    assert not asked


@pytest.mark.parametrize(
    "array",
    [np.zeros(4), np.zeros((5, 4))[2:, ::2], np.zeros(0), np.array(3), np.zeros(3, dtype=bool), np.zeros((2, 3)).T],
    ids=["plain", "strided", "empty", "single", "truths", "transposed"],
)
def test_where_an_array_lies_is_what_numpy_says(array: np.ndarray) -> None:
    assert address(array) == array.ctypes.data

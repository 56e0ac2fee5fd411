"""Rows of numbers are the bytes that Python writes, number by number."""

from __future__ import annotations

import numpy as np
import pytest

from artipg_dsl.export.decimals import Rows, fixed


@pytest.mark.parametrize("reach", [1.0, 20.0, 999.0])
def test_numbers_are_those_of_python(reach: float) -> None:
    values = np.random.default_rng(7).uniform(-reach, reach, (4000, 3))
    halves = (np.arange(-3000, 3000).reshape(-1, 3) + 0.5) / 1e6  # half way, as near as a number comes
    edges = np.array([[0.0, -0.0, 0.9999995], [-0.9999996, 9.9999999, 99.9999996], [1e-9, -1e-9, -5e-7]])
    for some in (values, halves, np.nextafter(halves, 1), edges, values.astype(np.float32)):
        expected = "".join(f"{x:.6f} {y:.6f} {z:.6f}\n" for x, y, z in (some + 0.0).tolist())
        assert bytes(Rows.joined([fixed(some + 0.0)])) == expected.encode()


def test_what_is_large_or_no_number_is_written_too() -> None:
    values = np.array([[1000.0, -123456.7891235, np.nan], [1.0, np.inf, 2.0]])
    expected = "".join(f"{x:.6f} {y:.6f} {z:.6f}\n" for x, y, z in values.tolist())
    assert bytes(Rows.joined([fixed(values)])) == expected.encode()


def test_columns_stand_beside_one_another() -> None:
    words = Rows.of(["12 7 255 1", "3"], np.array([1, 0, 1]))
    made = bytes(Rows.joined([fixed(np.array([[1.5], [-2.0], [0.25]])), words]))
    assert made == b"1.500000 3\n-2.000000 12 7 255 1\n0.250000 3\n"

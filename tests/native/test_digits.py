"""Numbers printed by compiled code are the bytes that Python writes."""

import numpy as np
import pytest

from artipg_dsl.export.decimals import numbers, told, told_twice
from artipg_dsl.native import backend
from artipg_dsl.native.digits import _printed, print_rows

from .machine import needs_compiler

MARKS = ("v ", " ", " ", "\n")


@pytest.fixture
def compiled(machine, monkeypatch):
    """The machine that all tests share: a backend chosen anew is compiled anew."""
    monkeypatch.setattr(backend, "machine", lambda: machine)


def some(kind):
    """Numbers (n, 3) of a kind on which printing may trip."""
    lots = np.random.Generator(np.random.PCG64(4))
    shape, tens = (2000, 3), 10.0 ** lots.integers(-12, 9, (2000, 3))
    return {
        "plain": lots.uniform(-2, 2, shape),
        "small": 10 ** lots.uniform(-29, 8, shape) * lots.choice([-1, 1], shape),
        "half way": (lots.integers(0, 10**8, shape) * 10 + 5) / 10.0 ** lots.integers(4, 15, shape),
        "exactly half way": (lots.integers(0, 2**18, shape) * 2 + 1) / 2.0 ** lots.integers(1, 12, shape),
        "powers of ten": tens,
        "beside them": np.nextafter(tens, lots.choice([0.0, 1e300], shape)),
        "nothing": lots.choice([0.0, -0.0], shape),
    }[kind]


@needs_compiler
@pytest.mark.parametrize("form", ["%.9g", "%.6g", "%.10g", "%.6f"])
@pytest.mark.parametrize(
    "kind", ["plain", "small", "half way", "exactly half way", "powers of ten", "beside them", "nothing"]
)
def test_numbers_are_those_of_python(compiled, form, kind):
    values = some(kind)
    left = 0
    for rows in np.split(values, 100):
        found = _printed(rows, form, MARKS)
        expected = "".join(f"v {form} {form} {form}\n" % tuple(row) for row in rows.tolist())
        assert print_rows(rows, form, MARKS) == expected
        assert found is None or found.decode() == expected
        left += found is None
    assert left < 100 or form == "%.6g"  # numbers above a million are left to Python


@needs_compiler
def test_whole_numbers_and_what_is_left_to_python(compiled):
    whole = np.array([[0, -1, 2**62], [-(2**63), 7, 10]] * 3)
    assert (
        print_rows(whole, "%d", ("f ", "//", " ", "\n"))
        == "f 0//-1 4611686018427387904\nf -9223372036854775808//7 10\n" * 3
    )
    for value in (np.nan, np.inf, -np.inf, 1e9, 1e300, 5e-324):
        rows = np.full((5, 3), value)
        assert _printed(rows, "%.9g", MARKS) is None
        assert print_rows(rows, "%.9g", MARKS) == f"v {value:.9g} {value:.9g} {value:.9g}\n" * 5


@pytest.mark.parametrize("with_machine", [False, pytest.param(True, marks=needs_compiler)])
def test_a_few_numbers_and_many(request, monkeypatch, with_machine):
    """Either way they are rounded as NumPy rounds them."""
    used = request.getfixturevalue("machine") if with_machine else None
    monkeypatch.setattr(backend, "machine", lambda: used)
    lots = np.random.Generator(np.random.PCG64(5))
    for count in (0, 1, 3, 60):
        values = np.concatenate([lots.normal(size=count), 1e-12 * lots.normal(size=count)])
        expected = " ".join(f"{value:.9g}" for value in (np.round(values, 12) + 0.0).tolist())
        assert numbers(values) == numbers(values.tolist()) == expected
    assert numbers([np.inf, 1e-13, 0.5]) == "inf 0 0.5"


@pytest.mark.parametrize("with_machine", [False, pytest.param(True, marks=needs_compiler)])
def test_rows_with_words(request, monkeypatch, with_machine):
    """Numbers, words or both, those that compiled code leaves to Python too."""
    used = request.getfixturevalue("machine") if with_machine else None
    monkeypatch.setattr(backend, "machine", lambda: used)
    words, which = ["7 7 255 1", "", "40"], np.arange(2000) % 3
    for kind in ("plain", "half way", "exactly half way", "nothing"):
        values = some(kind)
        rows = [f"{x:.6f} {y:.6f} {z:.6f}" for x, y, z in (values + 0.0).tolist()]
        assert told(values) == "".join(f"{row}\n" for row in rows).encode()
        both = "".join(f"{row} {words[k]}\n" for row, k in zip(rows, which.tolist(), strict=True))
        assert told(values, words, which) == both.encode()
        first = "".join(f"{x:.6f} {y:.6f}\n" for x, y in (values[:, :2] + 0.0).tolist())
        assert told_twice(values, 2, words, which) == (both.encode(), first.encode())
        assert told(values[:, :0], words, which) == "".join(f"{words[k]}\n" for k in which.tolist()).encode()
    assert told(np.array([[np.nan, 1e300]])) == f"nan {1e300:.6f}\n".encode()

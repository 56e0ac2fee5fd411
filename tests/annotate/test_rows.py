"""Rows as text are the JSON of the same rows as dictionaries, by compiled code and without it."""

from __future__ import annotations

import json

import numpy as np
import pytest
from native.machine import needs_compiler

from artipg_dsl.annotate.rows import Known, PerState, Rows, to_text
from artipg_dsl.native import backend, compiler, digits


@pytest.fixture(scope="module")
def machine():
    return backend.fit(compiler.kept() or compiler.compile_machine())


@pytest.fixture(params=[False, pytest.param(True, marks=needs_compiler)])
def used(request, monkeypatch):
    """Whether rows are printed by compiled code."""
    made = request.getfixturevalue("machine") if request.param else None
    monkeypatch.setattr(backend, "machine", lambda: made)
    return request.param


def numbers(kind: str, *shape: int) -> np.ndarray:
    """Numbers on which printing may trip."""
    lots = np.random.Generator(np.random.PCG64(8))
    sign = lots.choice([-1, 1], shape)
    return {
        "plain": lots.uniform(-2, 2, shape),
        "of all sizes": sign * 10 ** lots.uniform(-13, 5.9, shape),
        "short": sign * lots.integers(0, 10**4, shape) / 10.0 ** lots.integers(0, 10, shape),
        "half way": sign * (lots.integers(0, 10**6, shape) * 10 + 5) / 1e10,
        "exactly half way": sign * (lots.integers(0, 2**18, shape) * 2 + 1) / 2.0 ** lots.integers(8, 20, shape),
        "powers of ten": sign * 10.0 ** lots.integers(-12, 6, shape),
        "nothing": lots.choice([0.0, -0.0, 4e-10, -4e-10], shape),
        "large": sign * 10 ** lots.uniform(5, 20, shape),
    }[kind]


@pytest.mark.parametrize(
    "kind", ["plain", "of all sizes", "short", "half way", "exactly half way", "powers of ten", "nothing", "large"]
)
def test_numbers(used, kind):
    values, n = numbers(kind, 3000, 3), 3000
    values[::7, 0] = np.nan
    rows = Rows(np.arange(n) // 3, {"t": values[:, 0], "at": np.nan_to_num(values), "way": Known(values)})
    assert rows.text(n // 3) == [to_text(own) for own in rows.plain(n // 3)]
    assert json.loads(rows.text(n // 3)[0]) == rows.plain(n // 3)[0]
    assert rows.plain(n // 3)[0][0]["t"] is None and rows.plain(n // 3)[0][0]["way"] is None
    if used and kind != "large":  # numbers from a million on are left to Python
        assert digits.print_records([digits.Numbers(values[:, 0])], ("", "")) is not None


def test_words_whole_numbers_and_plain_data(used):
    owner = np.array([1, 1, 1, 3])
    columns = {
        'na"me': ["Öfen", 'in "quotes"', None, "line\n"],
        "place": np.array([0, -1, 2**40, 7]),
        "small": np.array([1, 2, 3, 65535], dtype=np.uint16),
        "of": [3, None, 3, 0],
        "held": np.array([True, False, True, True]),
        "reached": np.array([None, None, True, False]),
        "mimic": [None, {"joint": "a", "offset": 0.1}, None, {"joint": "b", "curve": [1, 2.5]}],
    }
    rows = Rows(owner, columns)
    assert rows.text(5) == [to_text(own) for own in rows.plain(5)]
    assert [len(own) for own in rows.plain(5)] == [0, 3, 0, 1, 0] and rows.text(5)[0] == "[]"
    states = PerState([{"parts": rows, "none": Rows(owner[:0], {"t": np.zeros(0)})}] * 2)
    assert states.text(5) == [to_text(own) for own in states.plain(5)]
    assert PerState([]).text(2) == ["[]", "[]"] and PerState([]).plain(2) == [[], []]


def test_what_json_cannot_say_is_refused(used):
    for column in (np.array([np.inf]), np.array([[0.0, np.nan]])):
        with pytest.raises(ValueError, match="not JSON compliant"):
            Rows(np.zeros(1, dtype=np.int64), {"t": column}).text(1)

"""The compiled backend for tests, and arrays compared by their bits."""

import numpy as np
import pytest

from artipg_dsl.native import backend, compiler

needs_compiler = pytest.mark.skipif(
    not compiler.compilers(), reason="there is no C compiler, and so no compiled backend: NumPy is used"
)


@pytest.fixture(scope="session")
def machine():
    return backend.fit(compiler.compile_machine())


@pytest.fixture
def using(monkeypatch):
    """Switches to a backend, until the test ends."""
    monkeypatch.setenv(backend.VARIABLE, "")
    yield backend.choose
    monkeypatch.undo()
    backend._state = backend._State()


def bits(value) -> bytes:
    array = np.ascontiguousarray(value)
    return array.dtype.str.encode() + array.tobytes()

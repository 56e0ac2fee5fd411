"""The compiled machine, and what switches between backends."""

import pytest

from artipg_dsl.native import backend, compiler


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

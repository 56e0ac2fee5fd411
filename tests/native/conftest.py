"""The compiled machine, and what switches between backends."""

import pytest

from artipg_dsl.native import backend, compiler


@pytest.fixture(scope="session")
def machine():
    return backend.fit(compiler.compile_machine())


@pytest.fixture(autouse=True)
def nothing_kept(monkeypatch):
    """These tests say themselves what is kept, and where."""
    monkeypatch.setenv("APGC_CACHE", "off")


@pytest.fixture
def using(monkeypatch):
    """Switches to a backend, until the test ends."""
    backend._state = backend._State()
    monkeypatch.setenv(backend.VARIABLE, "")
    yield backend.choose
    monkeypatch.undo()
    backend._state = backend._State()

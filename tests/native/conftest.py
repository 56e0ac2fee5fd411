"""The compiled machine, and what switches between backends."""

from pathlib import Path

import pytest

from artipg_dsl.native import backend, compiler

_fit, _compile = backend.fit, compiler.compile_machine


@pytest.fixture(scope="session")
def machine():
    return _fit(_compile())


@pytest.fixture
def nothing_kept(monkeypatch):
    """For tests that say themselves what is kept, and where, or whose programs are to be compiled anew."""
    monkeypatch.setenv("APGC_CACHE", "off")


def _switching(monkeypatch):
    backend._state = backend._State()
    monkeypatch.setenv(backend.VARIABLE, "")
    yield backend.choose
    monkeypatch.undo()
    backend._state = backend._State()


@pytest.fixture
def choosing(nothing_kept, monkeypatch):
    """Switches to a backend, until the test ends; the machine is compiled each time."""
    yield from _switching(monkeypatch)


@pytest.fixture
def using(monkeypatch, request):
    """The same, with one machine for all tests."""
    monkeypatch.setattr(compiler, "kept", Path)
    monkeypatch.setattr(backend, "fit", lambda _: request.getfixturevalue("machine"))
    yield from _switching(monkeypatch)

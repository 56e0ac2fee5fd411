"""Where primitives overlap: compiled code places, asks and weighs the points that NumPy does, to the last bit."""

import numpy as np
import pytest

from artipg_dsl.native import overlaps
from artipg_dsl.session import Session
from artipg_dsl.validity.mass import masses

from .machine import bits, needs_compiler

pytestmark = needs_compiler


@pytest.mark.parametrize("category", ["USB", "Laptop"])
def test_masses_have_the_same_bits(using, monkeypatch, category):
    sampler, calls, found = Session.of(category).sampler, [], []
    for word in ("place_shares", "local_points", "held_moments"):
        original = getattr(overlaps, word)
        monkeypatch.setattr(overlaps, word, lambda *a, of=original, called=word: calls.append(called) or of(*a))
    for backend in ("numpy", "c"):
        using(backend)
        assert (backend == "c") or not calls
        mass = masses(sampler.batch(np.arange(6), 5))
        found.append((mass.mass, mass.center, mass.inertia))
    for one, other in zip(*found, strict=True):
        assert bits(one) == bits(other)
    assert set(calls) == {"place_shares", "local_points", "held_moments"}

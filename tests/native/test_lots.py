"""Random words and addresses: compiled code and NumPy have the same."""

import numpy as np

from artipg_dsl import random

from .machine import bits, needs_compiler


def arguments():
    """Addresses, lanes and attempts as they are asked for: one for each, one for all, in other shapes and orders."""
    lots = np.random.Generator(np.random.PCG64(4))
    for size in (0, 1, 5, 3000):
        address = lots.integers(0, 2**64, size, dtype=np.uint64)
        for lane in (0, 0xFFFFFFFD, lots.integers(0, 2**32, size)):
            yield from ((address, lane, attempt) for attempt in (0, lots.integers(0, 2**32, size)))
    some = np.arange(12, dtype=np.uint64)
    yield from [(np.uint64(5), 3, 2), (np.uint64(5), some, 2), (some[::-5], 1, 2), (some.astype(np.int64) - 4, 1, 2)]
    yield some.reshape(3, 4), np.arange(4), np.arange(3)[:, None]


@needs_compiler
def test_words_and_addresses_are_the_same(machine, using):
    key, found = random.key(-5, "a", "b"), []
    for name in ("numpy", "c"):
        using(name)
        found.append(
            [
                bits(array)
                for address, lane, attempt in arguments()
                for array in (
                    random.uniform(key, address, lane, attempt),
                    *random.pair(key, address, lane, attempt),
                    random.streams(key, address, attempt),
                    random.mix(address, lane),
                    random.mix(address, np.asarray(attempt)),
                )
            ]
        )
    assert found[0] == found[1]


@needs_compiler
def test_the_backend_says_whose_they_are(machine, using, monkeypatch):
    asked, plain = [], random.philox
    monkeypatch.setattr(random, "philox", lambda *given: asked.append(given) or plain(*given))
    for name, times in (("c", 0), ("numpy", 1)):
        using(name)
        random.uniform(random.key(1, "a"), np.arange(3))
        assert len(asked) == times

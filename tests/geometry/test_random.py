"""The addressed random function against the published vectors, and the promises its users rely on."""

import numpy as np
import pytest

from artipg_dsl import random

VECTORS = [  # Random123, kat_vectors: philox4x32 10
    ((0, 0, 0, 0), (0, 0), (0x6627E8D5, 0xE169C58D, 0xBC57AC4C, 0x9B00DBD8)),
    ((0xFFFFFFFF,) * 4, (0xFFFFFFFF,) * 2, (0x408F276D, 0x41C83B0E, 0xA20BC7C6, 0x6D5451FD)),
    (
        (0x243F6A88, 0x85A308D3, 0x13198A2E, 0x03707344),
        (0xA4093822, 0x299F31D0),
        (0xD16CFE09, 0x94FDCCEB, 0x5001E420, 0x24126EA1),
    ),
]


@pytest.mark.parametrize(("counter", "key", "expected"), VECTORS)
def test_known_answers(counter, key, expected):
    words = random.philox((np.uint32(key[0]), np.uint32(key[1])), *counter)
    assert tuple(int(w) for w in words) == expected


def test_a_number_depends_on_its_address_alone():
    key = random.key(7, "points")
    addresses = np.arange(20_000, dtype=np.uint64) * np.uint64(0x123456789ABCDEF)
    whole = random.uniform(key, addresses, lane=3, attempt=1)
    for index in (0, 1, 8191, 8192, 19_999):
        assert random.uniform(key, addresses[index], lane=3, attempt=1) == whole[index]
    assert np.array_equal(random.uniform(key, addresses[::-7], 3, 1), whole[::-7])


def test_numbers_are_uniform_and_inside_the_open_interval():
    a, b = random.pair(random.key(1, "x"), np.arange(200_000, dtype=np.uint64))
    for numbers in (a, b):
        assert 0.0 < numbers.min() and numbers.max() < 1.0
        counts = np.histogram(numbers, 100, (0, 1))[0]
        assert ((counts - 2000.0) ** 2 / 2000.0).sum() < 160.0  # chi-square, 99 degrees of freedom
    assert abs(np.corrcoef(a, b)[0, 1]) < 0.01
    assert np.array_equal(a, random.uniform(random.key(1, "x"), np.arange(200_000)))


def test_keys_differ_by_seed_and_by_every_name():
    keys = {random.key(s, *names) for s in (0, 1, -1) for names in ((), ("a",), ("b",), ("a", "b"), ("ab",), ("a", ""))}
    assert len(keys) == 18


def test_child_addresses_do_not_meet():
    parents = np.arange(300, dtype=np.uint64)[:, None]
    children = random.mix(parents, np.arange(200))
    grand = random.mix(children[:20, :, None], np.arange(10))
    every = np.concatenate([parents.ravel(), children.ravel(), grand.ravel()])
    assert len(np.unique(every)) == len(every)
    assert random.mix(np.uint64(5), 3) == children[5, 3]


def test_coarse_numbers_are_those_of_splitmix64_and_of_their_lanes_alone():
    stream = np.array([1234567], dtype=np.uint64)
    # the first outputs of splitmix64 from the seed 1234567, as published with the generator
    known = np.array(
        [6457827717110365317, 3203168211198807973, 9817491932198370423, 4593380528125082431], dtype=np.uint64
    )
    u, v = random.coarse(np.repeat(stream, 4), np.arange(4))
    assert np.array_equal((u * 2.0**32).astype(np.uint64), known >> np.uint64(32))
    assert np.array_equal((v * 2.0**32).astype(np.uint64), known & np.uint64(0xFFFFFFFF))
    starts = random.streams(random.key(3, "coarse"), np.array([5, 2**40, 9], dtype=np.uint64), 2)
    which = np.repeat(starts, 20_000)
    lane = np.tile(np.arange(20_000), 3)
    u, v = random.coarse(which, lane)
    some = np.array([7, 59_999, 20_000, 8])
    assert np.array_equal(random.coarse(which[some], lane[some]), (u[some], v[some]))
    assert len(np.unique(np.concatenate([u, v]))) > 119_990 and 0 < min(u.min(), v.min()) and max(u.max(), v.max()) < 1
    for numbers in (u, v, (u + v) % 1.0):  # each bin within five deviations of its share
        counts = np.bincount((numbers * 64).astype(np.int64), minlength=64)
        assert (np.abs(counts - 60_000 / 64) < 5 * np.sqrt(60_000 / 64)).all()

"""Programs made to be hard: tight, contradictory, highly coupled. Each ends in objects or in a clear message, within seconds."""

import time

import numpy as np
import pytest

from artipg_dsl.diagnostics import CompileError
from artipg_dsl.errors import UserError
from artipg_dsl.run.job import prepare
from artipg_dsl.run.request import Request
from artipg_dsl.session import Session

SECONDS = 20.0  # of this process, on any machine; the slowest takes about two
NAMES = "abcdefghijkl"
SUM = " + ".join(NAMES)
ALL = ", ".join(NAMES)


def counts(names: str, most: int) -> str:
    return "".join(f"count {name} in 1 .. {most} = 1\n" for name in names)


VALID = {
    "a simplex of no width": f"param {ALL} : length in 1cm .. 12cm = 1cm\nrequire {SUM} >= 143.9cm",
    "a chain with both ends tied": "param {} : length in 1cm .. 20cm = 2cm\n{}\nrequire l >= a + 18.9cm".format(
        ALL, "\n".join(f"require {p} <= {q}" for p, q in zip(NAMES, NAMES[1:], strict=False))
    ),
    "everything beside everything": "param {} : length in 0cm .. 100cm = 1cm\n{}".format(
        ", ".join(NAMES[:6]),
        "\n".join(f"require {q} >= {p} + 15cm" for k, p in enumerate(NAMES[:6]) for q in NAMES[k + 1 : 6]),
    ),
    "keeping away from one another": "param a, b, c : length in 0cm .. 10cm = 1cm\n"
    "require abs(a - b) >= 3cm and abs(b - c) >= 3cm and abs(a - c) >= 3cm",
    "a thin ring": "param a, b : length in -10cm .. 10cm = 1cm\nrequire hypot(a, b) >= 9.9cm\nrequire hypot(a, b) <= 10cm",
    "products of products": "param a, b, c, d : length in 1cm .. 10cm = 2cm\nrequire a * b >= c * d\nrequire a * b <= 1.05 * c * d",
    "counts as far as they go": counts("ijk", 30) + "require i * j * k >= 20000\nrequire i + j <= 59",
    "all different": counts("ijkl", 4) + "require i != j and i != k and i != l and j != k and j != l and k != l",
    "an empty middle, twice": "param a : length in 0cm .. 1m = 1cm\nrequire a <= 1mm or a >= 99.9cm\nrequire abs(a - 50cm) <= 49.95cm",
    "one number for all": "param a, b : length in 1cm .. 10cm = 2cm\nrequire a <= b\nrequire b <= a",
    "a sum over a repeat that just fits": "count n in 1 .. 9 = 3\nrepeat s[i] in 0 ..< n { param w : length in 5cm .. 20cm = 6cm }\n"
    "require sum(s.w) <= 45.2cm",
    "a tail that nobody draws": "param a : length in 0cm .. 1m = 1cm ~ normal(5cm, 1mm)\nrequire a >= 90cm",
}

REFUSED = {
    "a circle of orders": (
        "impossible",
        "param a, b, c : length in 0cm .. 9cm = 1cm\nrequire a >= b + 1mm and b >= c + 1mm and c >= a + 1mm",
    ),
    "more than there is": ("impossible", f"param {ALL} : length in 1cm .. 12cm = 1cm\nrequire {SUM} >= 145cm"),
    "nothing beside the gap": ("impossible", "param a : length in 2cm .. 8cm = 3cm\nrequire a <= 1cm or a >= 9cm"),
    "a square below nothing": (
        "impossible",
        "param a, b : length in 1cm .. 2cm = 1cm\nrequire a * a + b * b <= 1cm * 1cm",
    ),
    "four in three places": (
        "No valid",
        counts("ijkl", 3) + "require i != j and i != k and i != l and j != k and j != l and k != l",
    ),
    "by a hair": ("No valid", "param a, b : ratio in 0.1 .. 1 = 0.5\nrequire sin(a * 1rad) * sin(b * 1rad) >= 0.7081"),
    "turned against itself": (
        "No valid",
        "param a : angle in 0deg .. 360deg = 10deg\nrequire sin(a) >= 0.5 and cos(a) >= 0.9",
    ),
    "an equation without a root": (
        "impossible",
        "param a : length in 1cm .. 2cm = 1cm\npart rod : Cuboid(size = [_, 1cm, 1cm])\nconnect rod to body\n"
        "align rod.size.x * rod.size.x + 1cm * 1cm = a * 0.1mm",
    ),
}


def program(body: str) -> Session:
    return Session.of_text(
        "apg 1\nuse primitives { Cuboid }\ncategory C {\n"
        + body
        + "\nroot part body : Cuboid(size = [5cm, 5cm, 1cm])\n}\n"
    )


@pytest.mark.parametrize("name", VALID)
def test_a_hard_program_is_sampled(name):
    begun = time.process_time()
    job = prepare(program(VALID[name]).sampler, Request("C", checked=False))
    batch = job.batch(np.arange(40))
    assert not batch.state.failed.any() and job.statistics.first_valid >= 8  # elements of one repeat are drawn together
    assert time.process_time() - begun < SECONDS


@pytest.mark.parametrize("name", REFUSED)
def test_a_program_without_objects_is_refused_in_words(name):
    begun = time.process_time()
    said, body = REFUSED[name]
    session = program(body)
    with pytest.raises((CompileError, UserError)) as caught:
        prepare(session.sampler, Request("C", checked=False)).batch(np.arange(40))
    if isinstance(caught.value, CompileError):
        assert said in [d.code for d in session.report.diagnostics]
        assert all(d.span is not None and d.hint for d in session.report.diagnostics)
    else:
        assert said.lower() in str(caught.value).lower() and "<text>:" in str(caught.value)
    assert time.process_time() - begun < SECONDS

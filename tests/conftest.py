"""Options of the test suite."""

import os
import shutil
import signal
import tempfile
import zlib
from collections import Counter
from collections.abc import Iterator
from functools import lru_cache

import pytest

from artipg_dsl import session
from artipg_dsl.graph.reading import from_text
from artipg_dsl.graph.writing import to_text
from artipg_dsl.lower import program as lowering

_KEPT = "ARTIPG_TEST_CACHE"
if _KEPT not in os.environ:  # one for the run: its workers and the commands that tests start inherit it
    os.environ[_KEPT] = os.environ["APGC_CACHE"] = tempfile.mkdtemp(prefix="apgc-tests-")

if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:  # in the background: what tests interrupt would ignore it, too
    signal.signal(signal.SIGINT, signal.default_int_handler)

session._read = lru_cache(maxsize=128)(session._read.__wrapped__)  # the shipped programs stay at hand

SMALL = 40  # parts: larger programs are verified pass by pass in tests/lower/test_passes.py
SHORT = 200_000  # characters: so are those with longer formulas
SEEN: set[int] = set()  # hashes of what has been verified
LONG: list[lowering.Lowering] = []  # the last one with longer formulas: passes make none shorter
PASSES = [step for stage in lowering.STAGES for step in stage if step.gives]


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Without ``ARTIPG_EVERY=1`` long tests are left out, and two of three cases of others, unless they are asked for by name. The
    shipped categories come first: what is compiled there is in the cache for all others."""
    if not os.environ.get("ARTIPG_EVERY") and not any("::" in name for name in config.args):
        left = {item for item in items if item.get_closest_marker("slow")}
        if not config.option.keyword:
            left |= _two_of_three([item for item in items if item.get_closest_marker("some")])
        config.hook.pytest_deselected(items=[item for item in items if item in left])
        items[:] = [item for item in items if item not in left]
    first = [item for item in items if item.path.name == "test_shipped.py"]
    others = [item for item in items if item.path.name != "test_shipped.py"]
    workers = int(os.environ.get("PYTEST_XDIST_WORKER_COUNT", "1"))  # each begins with an equal stretch of the list
    items[:] = [item for k in range(workers) for part in (first, others) for item in _stretch(part, k, workers)]


def _two_of_three(items: list[pytest.Item]) -> set[pytest.Item]:
    """Of the cases of each test all but the first, the fourth and so on."""
    counts: Counter[str] = Counter()
    left = set()
    for item in items:
        test = item.nodeid.partition("[")[0]
        if counts[test] % 3:
            left.add(item)
        counts[test] += 1
    return left


def _stretch(items: list[pytest.Item], number: int, count: int) -> list[pytest.Item]:
    return items[len(items) * number // count : len(items) * (number + 1) // count]


def pytest_unconfigure(config: pytest.Config) -> None:
    if not hasattr(config, "workerinput"):
        shutil.rmtree(os.environ.pop(_KEPT), ignore_errors=True)


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--update-golden", action="store_true", help="rewrite expected outputs instead of comparing")


@pytest.fixture
def update_golden(request: pytest.FixtureRequest) -> bool:
    return request.config.getoption("--update-golden")


def verified(step: lowering.Pass, done: lowering.Lowering) -> None:
    """What a pass leaves behind is a program: it is written and read back, which verifies it.

    What the last one leaves, in every second test; what another does, in one test of twelve, which are other tests for each pass.
    With ``ARTIPG_EVERY=1`` in all.
    """
    if not step.gives or done in LONG:
        return
    test = zlib.crc32(os.environ.get("PYTEST_CURRENT_TEST", "").encode())
    rare = 2 if step is PASSES[-1] else 12
    if (test + PASSES.index(step)) % rare and not os.environ.get("ARTIPG_EVERY"):
        return
    if not done.context.report.failed and len(done.program.parts) < SMALL:
        text = to_text(done.program)
        if len(text) >= SHORT:
            LONG[:] = [done]
        elif hash(text) not in SEEN:
            from_text(text)
            SEEN.add(hash(text))


@pytest.fixture(autouse=True, scope="session")
def verified_passes() -> Iterator[None]:
    """The programs that tests compile are verified after passes of the lowering."""
    lowering.WATCHERS.append(verified)
    yield
    lowering.WATCHERS.remove(verified)

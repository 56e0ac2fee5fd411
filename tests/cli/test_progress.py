"""Long work tells that it goes on, and what it is at, also where nobody watches a terminal."""

import io
import time
from argparse import Namespace

from artipg_dsl.cli import progress as module
from artipg_dsl.cli.progress import Progress


class Terminal(io.StringIO):
    def isatty(self):
        return True


def test_silent_for_short_work_where_nobody_watches():
    stream = io.StringIO()
    with Progress("Chest", stream) as progress:
        progress.stage("drawing")
        progress(1, 2)
    assert stream.getvalue() == ""


def test_a_line_now_and_then_with_the_stage(monkeypatch):
    monkeypatch.setattr(module, "SELDOM", 0.02)
    stream = io.StringIO()
    with Progress("validating", stream) as progress:
        progress.stage("checking them in all states")
        progress(1, 4)
        while stream.getvalue().count("\n") < 2:
            time.sleep(0.01)
    first = stream.getvalue().split("\n")[-2]
    assert first.startswith("validating: checking them in all states [") and "1/4" in first
    held = stream.getvalue()
    time.sleep(0.05)
    assert stream.getvalue() == held  # nothing after the work


def test_a_stage_that_is_counted_for_itself():
    stream = Terminal()
    with Progress("Chest", stream) as progress:
        progress.stage("pairs (step 4 of 7)", 0, 10)
        progress.drawn = 0.0
        progress.stage("pairs (step 4 of 7)", 5, 10)
        assert "5/10" in progress.line() and stream.getvalue().count("Chest: pairs (step 4 of 7) [") == 2
        progress.stage("sizes (step 5 of 7)", 0, 0)
        assert progress.line() == "Chest: sizes (step 5 of 7)"


def test_a_terminal_shows_the_stage_at_once_and_is_wiped():
    stream = Terminal()
    with Progress("Chest", stream) as progress:
        progress.stage("compiling")
        assert "Chest: compiling" in stream.getvalue()
    assert stream.getvalue().endswith("\r\x1b[K")


def test_long_work_on_one_of_several_processors_says_how_it_is_faster(monkeypatch):
    monkeypatch.setattr(module, "processors", lambda: 8)
    begun, one = time.monotonic() - 40, Namespace(workers=1)
    assert module.took(begun, one).endswith("s; `--workers auto` uses all 8 processors)")
    assert module.took(time.monotonic(), one) == "(0.0 s)"
    for other in ({"workers": 2}, {"workers": 1, "cluster": "local"}, {"workers": 1, "shard": (2, 8)}):
        assert module.took(begun, Namespace(**other)).endswith(" s)")
    assert module.took(begun, one, divisible=False).endswith(" s)")
    monkeypatch.setattr(module, "processors", lambda: 1)
    assert module.took(begun, one).endswith(" s)")

"""Whatever is wrong with a program, checking it ends in findings with places, never in an exception."""

import os

import pytest

from artipg_dsl.session import check_text
from artipg_dsl.source import Source

from .mutations import mutations, programs

MUTATIONS = list(mutations(seed=7, number=len(programs())))


TRIED = MUTATIONS if os.environ.get("ARTIPG_EVERY") == "1" else MUTATIONS[::6]


@pytest.mark.parametrize("text", [t for _, t in TRIED], ids=[name for name, _ in TRIED])
def test_no_exception(text: str) -> None:
    for found in check_text(Source("mutated.apg", text)).diagnostics:
        span = found.span
        assert found.message and (span is None or 0 <= span.start <= span.end <= len(span.source.text))


def test_all_programs_are_mutated() -> None:
    assert len(programs()) >= 40 and len(MUTATIONS) >= len(programs())
    assert len({text for _, text in MUTATIONS}) == len(MUTATIONS)

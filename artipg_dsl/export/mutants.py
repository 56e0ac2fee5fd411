"""Shards of what mutation did: traces of operations, and which primitive became which."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..sampling.correspondence import find_correspondence
from ..sampling.trace import trace_lines
from .containers import Arrays
from .content import Content

if TYPE_CHECKING:
    from ..runtime.batch import Batch

MEANINGS = {
    "object": "object number",
    "source": "the number of the object it was made from",
    "site": "the primitive, an index into `sites`",
    "rank": "its row among those of its site in the object",
    "before_site": "the primitive of the source that it corresponds to; -1 where there is none",
    "before_rank": "the row of that one",
    "how": "0 the same, 1 a replica of the nearest row, 2 by the slot of a role, 3 none",
    "position": "the place of its frame, metres, at joint values 0",
    "before_position": "that of its match; nan where there is none",
}


def trace_shard(batch: Batch, content: Content) -> bytes:
    """The lines of ``trace-<shard>.jsonl``: one object each."""
    del content
    return trace_lines(batch)


def correspondence_shard(batch: Batch, content: Content) -> Arrays:
    """The arrays of ``correspondence-<shard>.npz``: a row per primitive of the objects."""
    del content
    return find_correspondence(batch.history[0].before if batch.history else batch, batch).arrays()

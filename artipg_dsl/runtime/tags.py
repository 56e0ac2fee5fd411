"""Names as files take them, each once in its object."""

from __future__ import annotations

import re
from collections.abc import Sequence
from functools import lru_cache

import numpy as np

_RESERVED = re.compile("world|__.*__")  # what simulators call the ground, and what SDFormat keeps for itself


@lru_cache(maxsize=1 << 16)  # a batch has few names, each in many objects
def _tag(name: str) -> str:
    """A name that every format takes: ``pad.row[1].key[0].cap`` becomes ``pad.row_1.key_0.cap``, ``world`` ``world_1``."""
    tag = name.replace("[", "_").replace("]", "")
    return f"{tag}_1" if _RESERVED.fullmatch(tag) else tag


def make_distinct(names: Sequence[str], owner: np.ndarray) -> list[str]:
    """The tags of names, each once in its object: ``row[1]`` and a part called ``row_1`` stay two."""
    tags, owners = [_tag(name) for name in names], owner.tolist()
    taken = set(zip(owners, tags, strict=True))
    if len(taken) == len(tags):
        return tags
    found: dict[tuple[int, str], int] = {}
    for k, place in enumerate(zip(owners, tags, strict=True)):
        found[place] = found.get(place, 0) + 1
        while found[place] > 1 and (owners[k], f"{place[1]}_{found[place]}") in taken:
            found[place] += 1
        if found[place] > 1:
            tags[k] = f"{place[1]}_{found[place]}"
            taken.add((owners[k], tags[k]))
    return tags

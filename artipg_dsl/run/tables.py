"""The tables of a folder: its objects are made from their values, not drawn and checked again."""

from __future__ import annotations

import io
from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from ..errors import UserError
from ..export.registry import FORMATS, TABLES
from ..export.remote import Place
from ..files import read_arrays
from ..records import dataclass
from ..sampling.columns import TYPES, from_columns, take
from .chunk import shard_path
from .counts import Counts
from .schema import Runs, expand

if TYPE_CHECKING:
    from ..runtime.batch import Batch
    from .job import Job

_AGAIN = "give the command that wrote the folder again: it completes what is missing"


@dataclass(frozen=True, slots=True)
class Tables:
    """The shards of values in ``folder``, ``shard`` objects each, of the ``numbers`` of objects; ``counts`` of the run that
    wrote them all."""

    folder: Place
    numbers: Runs
    shard: int
    counts: Counts | None = None

    def batch(self, job: Job, numbers: np.ndarray) -> Batch:
        """Objects of a job by their numbers, ascending. Raises UserError."""
        stock = expand(self.numbers)
        place = np.minimum(np.searchsorted(stock, numbers), len(stock) - 1)
        absent = stock[place] != numbers
        if absent.any():
            raise UserError(f"{self.folder} has no object {numbers[absent][0]}", "see `numbers` in its manifest.json")
        parts, path = [], self.folder
        for shard in np.unique(place // self.shard).tolist():
            path = shard_path(self.folder, FORMATS[TABLES], shard)
            held, wanted = _read(path), place[place // self.shard == shard] - shard * self.shard
            parts.append(take(held, wanted[wanted < len(held["object"])]))
        columns = {name: np.concatenate([part[name] for part in parts]) for name in TYPES}
        if not np.array_equal(columns["object"], numbers):
            raise UserError(f"{path} holds other objects than it should", f"remove it, then {_AGAIN}")
        return from_columns(job.sampler, columns, job.request.seed, job.given, str(path))


def _read(path: Place) -> dict[str, np.ndarray]:
    """The arrays of a shard. Raises UserError."""
    try:
        found = read_arrays(io.BytesIO(path.read_bytes()), TYPES.__contains__)
    except FileNotFoundError:
        raise UserError(f"{path} is missing", _AGAIN) from None
    except (OSError, ValueError) as error:
        raise UserError(f"{path} cannot be read as values: {error}", f"remove it, then {_AGAIN}") from None
    if not _belong_together(found):
        raise UserError(f"{path} cannot be read as values: its arrays are not those", f"remove it, then {_AGAIN}")
    return found


def _belong_together(found: Mapping[str, np.ndarray]) -> bool:
    """Whether all arrays are there, with their types and as long as each other."""
    if found.keys() != TYPES.keys():
        return False
    shapes = all(array.ndim == (2 if name == "rows" else 1) for name, array in found.items())
    kinds = all(array.dtype.kind == np.dtype(TYPES[name]).kind for name, array in found.items())
    lengths = {len(array) for name, array in found.items() if shapes and name != "values"}
    return shapes and kinds and len(lengths) == 1 and int(found["rows"].sum(dtype=np.int64)) == len(found["values"])

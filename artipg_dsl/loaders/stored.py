"""Batches of what ``apgc sample`` has written: a folder, or several, of any categories, as one numbered set of items.

An item is an object in one of its states (and from one of its cameras, for ``completion``). Arrays are those of a ``Stream``; those that the
task needs are read when the first batch is made and kept, some 50 kB an item of 2,048 points.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import cached_property
from pathlib import Path

import numpy as np

from ..arguments import read_paths, read_whole
from ..errors import UsageError, UserError
from ..files import read_arrays
from ..run.manifest import Manifest
from ..run.resume import read_folder_manifest
from .classes import find_classes
from .draws import Draws, read_epoch
from .tasks import DTYPES, Arrays, find_task, stack_words
from .transforms import Transform, apply_transform, read_transforms

_WORD = "affordance."
_MOVED = ("points", "normals", "motion")  # these differ from state to state


class Stored:
    """``len(stored)`` items; ``stored.take(numbers)`` makes a batch of some of them.

    ``folders`` hold ``points-*.npz``, for completion ``views-*.npz`` too; all with as many points. ``seed`` is that of the transforms;
    ``classes`` are those of a ``Stream``.
    Raises UsageError, UserError, ExportError.
    """

    def __init__(
        self,
        folders: str | Path | Sequence[str | Path],
        task: str = "segmentation",
        *,
        seed: int = 0,
        classes: Mapping[str, str] | None = None,
        transforms: Iterable[Transform] = (),
    ):
        self.folders = [Path(f) for f in read_paths("folders", folders, 'Stored(["microwaves", "doors"])')]
        self.task, self.seed, self.transforms = find_task(task), read_whole("seed", seed), read_transforms(transforms)
        if not self.folders:
            raise UsageError("there is no folder to read", "name one that `apgc sample` has written")
        manifests = [read_folder_manifest(str(folder)) for folder in self.folders]
        self.categories = [manifest["category"] for manifest in manifests]
        self.words, self._tables = _common_words(self.folders, manifests, classes)
        self._sizes = [self._count_items(f, m) for f, m in zip(self.folders, manifests, strict=True)]

    def __len__(self) -> int:
        return sum(self._sizes)

    def take(self, items: Sequence[int] | np.ndarray, epoch: int = 0) -> Arrays:
        """The arrays of the items of the given numbers; ``epoch`` makes new numbers for the transforms.

        Raises IndexError, UsageError, UserError.
        """
        if not isinstance(items, Sequence | np.ndarray) or np.ndim(items) != 1:
            raise UsageError(f"items is {items!r}", "give their numbers: take([0, 3]), or range(32)")
        item = np.asarray([read_whole("an item", number) for number in items], dtype=np.int64)
        read_epoch(epoch)
        if item.size and not (0 <= item.min() and item.max() < len(self)):
            raise IndexError(f"there are {len(self)} items, no item {item.min() if item.min() < 0 else item.max()}")
        found = {name: array[item] for name, array in self._arrays.items()}
        labels = {name: found.pop(name) for name in [n for n in found if n.startswith(_WORD)]}
        if "affordance" in self.task.points:
            found["affordance"] = stack_words(labels, self.words["affordance"], found["points"].shape[:2])
        for name in [n for n in self.task.points if n in DTYPES]:
            found[name] = found[name].astype(DTYPES[name])
        known = {"object": found.pop("object"), "category": found.pop("category")}
        found = {name: found[name] for name in ("points", *self.task.points, "partial") if name in found}
        for rank, transform in enumerate(self.transforms):
            found = apply_transform(transform, found, Draws(self.seed, str(rank), item, epoch))
        return known | found

    @cached_property
    def _arrays(self) -> Arrays:
        """All items' arrays, folder after folder."""
        every = [self._read(k, folder) for k, folder in enumerate(self.folders)]
        names = {name for arrays in every for name in arrays}
        widths = sorted({arrays["points"].shape[1] for arrays in every})
        if len(widths) > 1:
            raise UserError(
                f"the folders have {widths[0]} and {widths[-1]} points", "sample them with the same --points"
            )
        return {
            name: np.concatenate([a.get(name, np.zeros(a["points"].shape[:2], bool)) for a in every]) for name in names
        }

    def _read(self, k: int, folder: Path) -> Arrays:
        """The items of one folder."""
        needed = {"points", *self.task.points} - {"affordance"}
        found = _read_shards(folder, "points", lambda n: n in {"object", *needed} or self._is_word(n))
        states = found["points"].shape[1] if found["points"].ndim == 4 else 1
        views = 1
        if self.task.partial:
            partial = _read_shards(folder, "views", lambda n: n == "cloud_points")["cloud_points"]
            partial = partial.reshape(len(partial), states, *partial.shape[-3:])
            views = partial.shape[2]
            found["partial"] = partial.reshape(-1, *partial.shape[-2:])
        items = {n: _to_items(a, n, states, views) if n != "partial" else a for n, a in found.items()}
        items["category"] = np.full(len(items["object"]), k)
        if self._tables is not None and "semantic" in items:
            items["semantic"] = self._tables[k].astype(items["semantic"].dtype)[items["semantic"]]
        return items

    def _is_word(self, name: str) -> bool:
        return "affordance" in self.task.points and name.startswith(_WORD) and not name.endswith(".joint")

    def _count_items(self, folder: Path, manifest: Manifest) -> int:
        """Of a folder, as its manifest tells."""
        formats = manifest["identity"]["formats"]
        for name in ["points", *(["views"] if self.task.partial else [])]:
            if name not in formats:
                more = "--views 8" if name == "views" else "--format points"
                raise UserError(f"{folder} holds no {name}.npz", f"sample it again with {more}")
        arrays = manifest.get("arrays", {})
        for name in self.task.points:
            if name not in arrays and name != "affordance":
                raise UserError(f"{folder} holds no array `{name}`", f"sample it again with --{name}")
        rows, objects = len(_read_shards(folder, "points", lambda n: n == "object")["object"]), int(manifest["objects"])
        if rows != objects:
            raise UserError(
                f"{folder} has points of {rows} things for {objects} objects",
                "complete it with the command that made it, and sample points without --per",
            )
        first = _read_shards(folder, "points", lambda n: n == "points", most=1)
        states = first["points"].shape[1] if first["points"].ndim == 4 else 1
        views = 1
        if self.task.partial:
            views = _read_shards(folder, "views", lambda n: n == "cloud_points", most=1)["cloud_points"].shape[-3]
        return objects * states * views


def _to_items(array: np.ndarray, name: str, states: int, views: int) -> np.ndarray:
    """(B, ...), or (B, K, n, 3) where points move, to a row per object, state and view."""
    rows = array.reshape(-1, *array.shape[-2:]) if name in _MOVED else np.repeat(array, states, axis=0)
    return np.repeat(rows, views, axis=0)


def _read_shards(folder: Path, kind: str, wanted: Callable[[str], bool], most: int | None = None) -> Arrays:
    """The wanted arrays of all shards of a kind, put together. Raises UserError."""
    paths = sorted(folder.glob(f"{kind}-*.npz"))[:most]
    if not paths:
        raise UserError(
            f"{folder} has no {kind}-*.npz yet", "run the command that makes it again: it goes on where it was"
        )
    parts = []
    for path in paths:
        try:
            with open(path, "rb") as file:
                parts.append(read_arrays(file, wanted))
        except (OSError, ValueError) as error:
            raise UserError(
                f"{path} cannot be read: {error}",
                "remove it, and run the command that made it again: that makes what is missing",
            ) from None
    return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}


def _common_words(
    folders: Sequence[Path], manifests: Sequence[Manifest], classes: Mapping[str, str] | None
) -> tuple[dict[str, list[str]], list[np.ndarray] | None]:
    """What numbers mean, which all folders have to agree on unless ``classes`` are named, and the class of each word of each
    folder. Raises UserError, UsageError."""
    words = [manifest["vocabularies"].get("semantic", []) for manifest in manifests]
    found = find_classes(classes, words)
    if found is None:
        odd = next(k for k, other in enumerate(words) if other != words[0])
        raise UserError(
            f"{folders[0]} and {folders[odd]} number their semantic classes differently",
            "sample them with one version, or name `classes` of your own",
        )
    known = {n.removeprefix(_WORD) for m in manifests for n in m.get("arrays", {}) if n.startswith(_WORD)}
    return {"semantic": found[0], "affordance": sorted(n for n in known if not n.endswith(".joint"))}, found[1]

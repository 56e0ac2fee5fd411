"""Batches of what ``apgc sample`` has written: a folder, or several, of any categories, as one numbered set of items.

An item is an object in one of its states (and from one of its cameras, for ``completion``). Arrays are those of a ``Stream``; those that the
task needs are read at once and kept, some 50 kB an item of 2,048 points.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from ..arguments import read_paths, read_whole
from ..errors import UsageError, UserError
from ..files import read_arrays
from ..records import dataclass
from ..run.manifest import Manifest
from ..run.resume import read_folder_manifest
from .classes import find_classes
from .draws import Draws, read_epoch
from .tasks import DTYPES, Arrays, Task, find_task, stack_words
from .transforms import Transform, apply_transform, read_transforms

_WORD = "affordance."
_MOVED = ("points", "normals", "motion")  # these differ from state to state


@dataclass(frozen=True, slots=True)
class _Held:
    """Arrays, and where they say what they say of each item: ``moved`` (I,) are its rows in those of ``_MOVED``, ``object`` (I,) in others.
    ``partial`` has a row for each item."""

    arrays: Arrays
    moved: np.ndarray
    object: np.ndarray

    def take(self, item: np.ndarray) -> Arrays:
        """The rows of some items."""
        rows = {"partial": item, **dict.fromkeys(_MOVED, self.moved[item])}
        return {name: array[rows.get(name, self.object[item])] for name, array in self.arrays.items()}


class Stored:
    """``len(stored)`` items; ``stored.take(numbers)`` makes a batch of some of them.

    ``folders`` hold ``points-*.npz``, for completion ``views-*.npz`` too; all with as many points. ``seed`` is that of the transforms;
    ``classes`` are those of a ``Stream``. A copy by pickle reads the folders again.
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
        if twice := next((f for k, f in enumerate(self.folders) if f in self.folders[:k]), None):
            raise UsageError(f"{twice} is named twice: each of its items would come twice", "name it once")
        manifests = [read_folder_manifest(str(folder)) for folder in self.folders]
        self.categories = [manifest["category"] for manifest in manifests]
        self.words, self._tables = _common_words(self.folders, manifests, classes)
        for folder, manifest in zip(self.folders, manifests, strict=True):
            _check_arrays(folder, manifest, self.task)
        self._counts = [int(manifest["objects"]) for manifest in manifests]
        self._held  # noqa: B018  # told here, not in a worker, what cannot be read; and workers that are forked share what is

    def __len__(self) -> int:
        return len(self._held.object)

    def __getstate__(self) -> dict[str, Any]:
        """Another process reads the folders itself: that takes less time than to send what they hold."""
        return {name: value for name, value in self.__dict__.items() if name != "_held"}

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
        found = self._held.take(item)
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
    def _held(self) -> _Held:
        """What all folders hold, one after the other."""
        every = [
            self._read(k, folder, count)
            for k, (folder, count) in enumerate(zip(self.folders, self._counts, strict=True))
        ]
        for name, hint in (
            ("points", "sample them with the same --points"),
            ("partial", "sample them with one camera file"),
        ):
            widths = sorted({held.arrays[name].shape[-2] for held in every if name in held.arrays})
            if len(widths) > 1:
                of = "points" if name == "points" else "points in their views"
                raise UserError(f"the folders have {widths[0]} and {widths[-1]} {of}", hint)
        names = {name for held in every for name in held.arrays}
        none = [
            np.zeros((len(held.arrays["object"]), held.arrays["points"].shape[1]), bool) for held in every
        ]  # of a word unknown there
        arrays = {
            name: np.concatenate([held.arrays.get(name, unknown) for held, unknown in zip(every, none, strict=True)])
            for name in names
        }
        moved = np.cumsum([0, *(len(held.arrays["points"]) for held in every[:-1])])
        objects = np.cumsum([0, *self._counts[:-1]])
        return _Held(
            arrays,
            np.concatenate([first + held.moved for first, held in zip(moved, every, strict=True)]),
            np.concatenate([first + held.object for first, held in zip(objects, every, strict=True)]),
        )

    def _read(self, k: int, folder: Path, objects: int) -> _Held:
        """What one folder of so many objects holds. Raises UserError."""
        needed = {"object", "points", *self.task.points}
        found = _read_shards(folder, "points", lambda name: name in needed or self._is_word(name))
        if (rows := len(found["object"])) != objects:
            raise UserError(
                f"{folder} has points of {rows} things for {objects} objects",
                "complete it with the command that made it, and sample points without --per",
            )
        states, views = found["points"].shape[1] if found["points"].ndim == 4 else 1, 1
        for name in _MOVED:
            if name in found:
                found[name] = found[name].reshape(-1, *found[name].shape[-2:])
        if self.task.partial:
            seen = _read_shards(folder, "views", lambda name: name in {"object", "cloud_points"})
            if not np.array_equal(seen["object"], found["object"]):
                raise UserError(
                    f"{folder} has views of {len(seen['object'])} of its {objects} objects",
                    "complete it with the command that made it",
                )
            cloud = seen["cloud_points"]
            views, found["partial"] = cloud.shape[-3], cloud.reshape(-1, *cloud.shape[-2:])
        found["category"] = np.full(objects, k)
        if self._tables is not None and "semantic" in found:
            found["semantic"] = self._tables[k].astype(found["semantic"].dtype)[found["semantic"]]
        moved = np.repeat(np.arange(objects * states), views)
        return _Held(found, moved, moved // states)

    def _is_word(self, name: str) -> bool:
        return "affordance" in self.task.points and name.startswith(_WORD) and not name.endswith(".joint")


def _check_arrays(folder: Path, manifest: Manifest, task: Task) -> None:
    """Whether a folder was sampled with what a task needs, as its manifest tells. Raises UserError."""
    for name in ["points", *(["views"] if task.partial else [])]:
        if name not in manifest["identity"]["formats"]:
            more = "--views 8" if name == "views" else "--format points"
            raise UserError(f"{folder} holds no {name}.npz", f"sample it again with {more}")
    for name in task.points:
        if name not in manifest.get("arrays", {}) and name != "affordance":
            raise UserError(f"{folder} holds no array `{name}`", f"sample it again with --{name}")


def _read_shards(folder: Path, kind: str, wanted: Callable[[str], bool]) -> Arrays:
    """The wanted arrays of all shards of a kind, put together. Raises UserError."""
    paths = sorted(folder.glob(f"{kind}-*.npz"))
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

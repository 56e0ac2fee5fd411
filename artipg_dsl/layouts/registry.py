"""The layouts that objects can be written in. A new one is one entry here and one file beside it.

The entries name functions as ``module:function``, so that a list of layouts costs no import.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import field
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO

from ..diagnostics.suggest import any_of, did_you_mean
from ..errors import UserError
from ..extras import H5PY, SAPIEN, Package
from ..records import dataclass
from .words import Term, check_words, vocabulary

if TYPE_CHECKING:
    import numpy as np

    from ..graph.program import Program
    from ..runtime.batch import Batch
    from .entry import Entry, Shares
    from .findings import Findings


@dataclass(frozen=True, slots=True)
class Layout:
    """``files(batch, entry, shard)`` yields the files of objects that are made together; ``index(entries)`` gives those that
    tell of all categories in the folder (a name that ends in ``/`` is a folder; what is large is a function that writes it to a
    stream), ``index(entries, folder)`` where it ``gathers`` from what has been written; ``check(folder, entry, batch, shard,
    findings)`` reads the files of a chunk as the field's loaders do and compares them with the model.

    ``vocabulary``: a closed one, which has to have a class for the category; ``judge(term)`` says what is wrong with a map to
    it. ``words(program)``: what the index needs of a program beside that. ``names(entry)``: what objects are called in names of
    files, by number, where that is neither their token nor their id. ``needs``: a package beyond what is always installed,
    ``too`` another. ``chunk``: objects that are made together. ``divides``: each point has a class of its own, so words that
    hold on some of a part count. ``alone``: names of objects say their class and no more, so two categories of one class need a
    folder each. ``frame``: the shipped one by which objects lie as in the data set, where they do not lie so by themselves.
    ``stumbles``: text in a path that its loaders read as something else. ``least``: by split, how many objects training needs,
    and why. ``unseen``: the folder of categories of which nothing is for training, where training needs one.
    """

    name: str
    title: str
    files_by: str
    index_by: str
    check_by: str
    vocabulary: str = ""
    judge_by: str = ""
    words_by: str = ""
    names_by: str = ""
    needs: Package | None = None
    too: Package | None = None
    chunk: int = 64
    gathers: bool = False
    divides: bool = False
    alone: bool = False
    frame: str = ""
    stumbles: str = ""
    least: Mapping[str, tuple[int, str]] = field(default_factory=dict)
    unseen: str = ""

    def entry(
        self, program: Program, seed: int, numbers: np.ndarray, shares: Shares, own: Mapping[str, Any] | None = None
    ) -> Entry:
        """What a folder holds of the objects of a program, ``own`` words first. Raises UserError."""
        from .entry import Entry  # start-up: a list of layouts needs no arrays

        if own and self.vocabulary and program.name not in own:
            names = ", ".join(own)
            hint = did_you_mean(program.name, own) or "leave --map out, or give the file that maps it"
            raise UserError(f"--map says nothing of {program.name}, it maps {names}", hint)
        term = self.term(program.name, own)
        if term is not None and own:
            self._check_map(program, own)
        words = _function(self.words_by)(program) if self.words_by else {}
        return Entry(program.name, seed, numbers, shares, term, words, self.chunk)

    def term(self, category: str, own: Mapping[str, Any] | None = None) -> Term | None:
        """The category in the layout's vocabulary, None where it has none. Raises UserError."""
        if not self.vocabulary:
            if own:
                raise UserError(f"{self.name} takes any category as it is", "leave --map out")
            return None
        term = vocabulary(self.vocabulary).term(category, own)
        wrong = _function(self.judge_by)(term) if self.judge_by else None
        if wrong:
            raise UserError(f"{category} in {self.name}: {wrong}", "correct the file of --map")
        return term

    def _check_map(self, program: Program, own: Mapping[str, Any]) -> None:
        """All that a user's map says of a category is of some use. Raises UserError."""
        parts = own[program.name].get("parts", {})
        if parts and not self.judge_by:
            raise UserError(f"{self.name} has no parts, only a class", f"leave `parts` of {program.name} out of --map")
        check_words(parts, program, divides=self.divides)
        formulas = [key for key in parts if "." in key]
        if formulas and not self.divides:
            takes = any_of([entry.name for entry in LAYOUTS.values() if entry.divides], "and")
            hint = f"{takes} take words of other vocabularies than semantic"
            raise UserError(f"{self.name} takes whole parts, which `{formulas[0]}` may divide", hint)

    def files(self, batch: Batch, entry: Entry, shard: int) -> Iterator[tuple[str, bytes]]:
        return _function(self.files_by)(batch, entry, shard)

    def names(self, entry: Entry) -> dict[str, int]:
        """The numbers of objects by what they are called in names of files."""
        own = _function(self.names_by)(entry) if self.names_by else {}
        numbers = entry.numbers.tolist()
        return {name: n for n in numbers for name in (entry.token(n), str(entry.id(n)))} | {own[n]: n for n in own}

    def index(self, entries: Sequence[Entry], folder: Path) -> Mapping[str, bytes | Callable[[BinaryIO], None]]:
        return _function(self.index_by)(entries, *([folder] if self.gathers else []))

    def check(self, folder: Path, entry: Entry, batch: Batch, shard: int, found: Findings) -> None:
        _function(self.check_by)(folder, entry, batch, shard, found)


def _function(place: str) -> Any:
    module, function = place.split(":")
    return getattr(import_module(f".{module}", __package__), function)


_BATCH = (32, "PointNet's script takes whole batches, of 32 unless --batch says otherwise, and divides by their number")
_TENTH = (10, "PoinTr's training divides by a tenth of their number")
LAYOUTS: dict[str, Layout] = {
    entry.name: entry
    for entry in (
        Layout(
            "shapenetpart",
            "part segmentation as ShapeNetPart has it, text",
            "shapenetpart:text_files",
            "shapenetpart:text_index",
            "shapenetpart:check_text",
            "shapenetpart",
            "shapenetpart:check_term",
            divides=True,
        ),
        Layout(
            "shapenetpart-h5",
            "the same, HDF5",
            "shapenetpart:h5_files",
            "shapenetpart:h5_index",
            "shapenetpart:check_h5",
            "shapenetpart",
            "shapenetpart:check_term",
            needs=H5PY,
            divides=True,
            gathers=True,
            least={"train": _BATCH, "val": _BATCH},
        ),
        Layout(
            "partnet-seg",
            "part segmentation as PartNet has it, by level and by instance, HDF5",
            "partnet.files:files",
            "partnet.files:index",
            "partnet.files:check",
            words_by="partnet.files:words",
            needs=H5PY,
            chunk=32,
            gathers=True,
            frame="partnet",
        ),
        Layout(
            "gapartnet",
            "part poses as GAPartNet has them: views with parts and normalised coordinates",
            "gapartnet.points:files",
            "gapartnet.points:index",
            "gapartnet.points:check",
            "gapartnet",
            "gapartnet.parts:check_term",
            chunk=4,
            frame="partnet",
            unseen="test_inter",
        ),
        Layout(
            "gapartnet-views",
            "what GAPartNet's tools are given and make: annotated folders and rendered views",
            "gapartnet.views:files",
            "gapartnet.views:index",
            "gapartnet.views_check:check",
            "gapartnet",
            "gapartnet.parts:check_term",
            chunk=1,
            frame="partnet",
        ),
        Layout(
            "ancsh",
            "part poses as NPCS and ANCSH have them: views part by part, HDF5",
            "ancsh.files:files",
            "ancsh.files:index",
            "ancsh.check:check",
            "ancsh",
            "ancsh.files:check_term",
            names_by="ancsh.files:object_names",
            needs=H5PY,
            chunk=4,
            gathers=True,
            alone=True,
            stumbles=".",
            least={
                "test": (
                    2,
                    "the training divides by the number of those that it calls unseen, and by that of all others",
                )
            },
        ),
        Layout(
            "cage",
            "trees of joints and boxes as CAGE and SINGAPO have them",
            "cage:files",
            "cage:index",
            "cage:check",
            "cage",
            "cage:check_term",
            gathers=True,
            frame="partnet",
        ),
        Layout(
            "opd",
            "pictures with the parts that open and how they move, as OPD and OPDMulti have them, HDF5",
            "opd.files:files",
            "opd.lists:index",
            "opd.check:check",
            "opd",
            "opd.files:check_term",
            needs=H5PY,
            chunk=4,
            gathers=True,
            alone=True,
            frame="partnet",
        ),
        Layout(
            "maniskill",
            "folders and lists that ManiSkill's tasks on PartNet-Mobility read",
            "maniskill.files:files",
            "maniskill.files:index",
            "maniskill.check:check",
            "maniskill",
            "maniskill.files:check_term",
            chunk=16,
            gathers=True,
            frame="partnet",
        ),
        Layout(
            "ditto",
            "an object before and after one of its joints has moved, as Ditto has it",
            "ditto:files",
            "ditto:index",
            "ditto:check",
            chunk=4,
            gathers=True,
        ),
        Layout(
            "where2act",
            "trials of a hand at points of an object, as Where2Act and Where2Explore have them, by physics",
            "where2act.files:simulated_files",
            "where2act.files:index",
            "where2act.check:check_simulated",
            needs=H5PY,
            too=SAPIEN,
            chunk=1,
            gathers=True,
            frame="partnet",
        ),
        Layout(
            "where2act-foretold",
            "the same trials as annotations say they come out, without a simulator",
            "where2act.files:foretold_files",
            "where2act.files:index",
            "where2act.check:check_foretold",
            needs=H5PY,
            chunk=1,
            gathers=True,
            frame="partnet",
        ),
        Layout(
            "pcn",
            "completion as PCN has it: whole clouds, and what a depth camera sees of them",
            "completion:pcn_files",
            "completion:pcn_index",
            "completion:check_pcn",
            "shapenet",
            chunk=16,
            stumbles="complete",
            least={"test": _TENTH},
        ),
        Layout(
            "shapenet55",
            "completion as ShapeNet-55 has it: whole clouds, of which loaders take parts away",
            "completion:shapenet_files",
            "completion:shapenet_index",
            "completion:check_55",
            "shapenet",
            chunk=32,
            least={"test": _TENTH},
        ),
    )
}


def require(layout: Layout) -> None:
    """Raise UserError where a layout's package is not installed."""
    for package in (layout.needs, layout.too):
        if package is not None:
            package.require(layout.name)

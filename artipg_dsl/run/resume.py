"""Folders that exist: the job that made one, and whether a run may go on in it."""

from __future__ import annotations

import re
import shutil
from contextlib import suppress
from dataclasses import replace

from ..details.dressing import BESIDE, SUMMARY
from ..diagnostics import CompileError
from ..errors import FORCE, UsageError, UserError
from ..export.objects import OBJECTS
from ..export.registry import FORMATS, TABLES
from ..export.remote import Place, Remote, place_of
from ..export.write import ExportError, ensure_folder, explain, sweep_unfinished, write_bytes
from ..version import __version__
from . import manifest as manifests
from .folders import refuse_others
from .job import Job, ProgramChanged, open_job
from .manifest import Manifest
from .request import Request, is_file
from .tables import Tables
from .traces import REPLAYS

REPEAT = f"choose another folder, repeat the old options to complete them, or use {FORCE} to replace them"
_REPLACE = f"choose another folder, or use {FORCE} to replace what is there"
_COUNTS = "counts-*.json"
_OURS = re.compile(r"[a-z]+-([0-9]{5,}|[0-9]{5,}-[0-9]{5,}|[0-9a-f]{32})(\.[a-z0-9]+)+")


def reopen(folder: Place | str) -> Job:
    """The job that a folder of samples was made by. Raises ExportError, UserError."""
    return remake(folder, read_folder_manifest(folder))


def read_folder_manifest(folder: Place | str) -> Manifest:
    """The manifest of a folder of samples. Raises ExportError, UserError."""
    manifest = manifests.read_manifest(folder)
    if manifest is None:
        if (place_of(folder) / SUMMARY).is_file():
            raise UserError(f"{folder} holds details", f"objects wear them: apgc mutate FITTED --details {folder}")
        if not place_of(folder).exists():
            raise UserError(f"there is no folder {folder}", manifests.WANTED)
        raise UserError(f"{folder} has no {manifests.NAME}", manifests.WANTED)
    return manifest


def remake(folder: Place | str, manifest: Manifest) -> Job:
    """The job that the manifest of a folder tells of; where it has tables, objects are made from these. Raises UserError."""
    identity = manifest["identity"]
    try:
        job = open_job(Request.from_manifest(identity, manifest["source"], place_of(folder)))
    except ProgramChanged as error:
        version = identity["artipg_dsl"]
        if version == __version__:
            raise
        raise ProgramChanged(error.source, error.made, error.now, version) from None
    except CompileError:
        if is_file(manifest["source"]):
            raise
        raise UserError(
            f"{folder} was made by a program `{manifest['source']}` that is neither shipped nor in a file",
            "text given to `load` is not kept: write it to a file, and make the folder by `sample`",
        ) from None
    except UsageError as error:  # what the manifest says, nobody has typed
        raise UserError(f"{place_of(folder) / manifests.NAME}: {error.message}", error.hint) from None
    if TABLES not in identity["formats"] or job.request.mutations:  # mutants are told by what made them, too
        return job
    tables = Tables(place_of(folder), job.request.numbers, identity["shard"], manifest.get("counts"))
    return replace(job, tables=tables)


def make_ready(out: Place, manifest: Manifest, force: bool) -> Manifest:
    """Make the folder ready: keep what belongs to the same options, refuse (or with ``force`` remove) anything else.

    Returns the manifest that holds: the old one where its files are kept.
    """
    refuse_others(out, "samples", "fitted objects", hint="samples go into a folder of their own")
    old = _read_or_replace(out, force)
    if old is not None:
        changed = manifests.describe_difference(old, manifests.expect_added(old, manifest))
        if changed and not force:
            raise ExportError(f"{out} holds samples made with other options: {changed}", REPEAT)
        if not changed and not force:
            sweep_all(out)
            return old
        clear(out)
    elif out.is_dir() and (left := _find_shards(out) + _find_objects(out)):
        _replace_unknown(out, left, force)
    ensure_folder(out)
    sweep_unfinished(out)
    write_bytes(out / manifests.NAME, manifests.to_text(manifest), force=True)
    return manifest


def _read_or_replace(out: Place, force: bool) -> Manifest | None:
    """The manifest of a folder, None where there is none, or with ``force`` a broken one beside what a run has written."""
    try:
        return manifests.read_manifest(out)
    except ExportError as wrong:
        ours = bool(_find_shards(out) or _find_objects(out)) if out.is_dir() else False
        if ours and force:
            return None
        hint = _REPLACE if ours else wrong.hint
        raise ExportError(wrong.message, hint) from None


def _replace_unknown(out: Place, left: list[Place], force: bool) -> None:
    """Refuse, or with ``force`` remove, what is ``left`` of a run without its manifest, such as one that was killed as it replaced a folder:
    files are not made again where they are, so they would pass for those of this run."""
    if not force and manifests.read_manifest(out) is None:  # else the same command elsewhere has begun meanwhile
        raise ExportError(
            f"{out} holds {str(left[0]).removeprefix(f'{out}/')}, but there is no {manifests.NAME} that describes it",
            _REPLACE,
        )
    try:
        for place in left if force else ():
            _remove(place)
    except OSError as error:
        raise explain(error, out) from error


def withdraw(out: Place) -> None:
    """Remove what a run has begun that failed before it wrote an object: with what was wrong put right, it is another run."""
    replays: list[Place] = list(out.glob(REPLAYS))
    names = {path.name for path in out.iterdir()} - {path.name for path in replays}
    if names - {BESIDE} == {manifests.NAME}:
        for path in (out / manifests.NAME, *replays):
            path.unlink()
        if not isinstance(out, Remote) and BESIDE not in names:
            out.rmdir()


def sweep_all(out: Place) -> None:
    """Remove what killed processes left unfinished in a folder of samples."""
    for place in (out, out / OBJECTS):
        if place.is_dir():
            sweep_unfinished(place)


def clear(out: Place) -> None:
    """Remove what an earlier run wrote, and nothing else."""
    try:
        (out / manifests.NAME).unlink()  # first, so that a half-cleared folder does not pass for a whole one
        for place in (*_find_shards(out), out / OBJECTS):
            _remove(place)
    except OSError as error:
        raise explain(error, out) from error


def _remove(place: Place) -> None:
    """Remove a file or folder, if it is there."""
    if isinstance(place, Remote):
        place.remove()
    elif place.is_dir() and not place.is_symlink():
        with suppress(FileNotFoundError):  # the same command elsewhere was sooner
            shutil.rmtree(place)
    else:
        place.unlink(missing_ok=True)


def _find_shards(out: Place) -> list[Place]:
    """The files in a folder that are named as those of shards, or as what lies beside them, by name."""
    kinds = {f"{entry.kind}-*{entry.suffix}" for entry in FORMATS.values() if entry.shard}
    found = {path.name for pattern in (*kinds, _COUNTS, REPLAYS) for path in out.glob(pattern)}
    return [out / name for name in sorted(found) if _OURS.fullmatch(name)]


def _find_objects(out: Place) -> list[Place]:
    """The folders of objects in a folder, by number."""
    there = (out / OBJECTS).iterdir() if (out / OBJECTS).is_dir() else ()
    return [out / OBJECTS / name for name in sorted(path.name for path in there) if re.fullmatch("[0-9]{6,}", name)]


def drop_counts(out: Place) -> None:
    """Remove what was counted shard by shard, once the manifest has it."""
    for path in out.glob(_COUNTS):
        path.unlink(missing_ok=True)

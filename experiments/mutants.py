"""What is made from real objects: each is fitted by itself, and mutated.

A cloud's ``origin`` is the one real object that it was made from, so that what was made from an object that is held out is left out with it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import artipg_dsl as apg
from artipg_dsl.annotate.cloud import sample_points
from artipg_dsl.annotate.sampling import Sampling
from artipg_dsl.api import Samples
from artipg_dsl.details.store import dress, read_dressing
from artipg_dsl.export.containers import npz_bytes
from artipg_dsl.fit.pose import Frame
from artipg_dsl.fit.sources import File, Item
from artipg_dsl.run.binding import Binding
from artipg_dsl.run.bindings import write_bindings
from artipg_dsl.run.fits import Folder, write_fits
from artipg_dsl.run.fitting import Asked
from artipg_dsl.run.job import open_program
from artipg_dsl.sampling.mutation import Mutation

from .clouds import Clouds
from .ours import STATES, motion_clouds
from .real import Real

BOUND = 8192  # points of a structure and of a real surface that are assigned to one another


@dataclass(frozen=True, slots=True)
class Fit:
    """A real object (``origin``, its row) as an object of ours in the folder ``fitted``, its details in ``bound``."""

    origin: int
    category: str
    name: str
    fitted: Path
    bound: Path


def fit_each(objects: Mapping[int, Real], folder: Path) -> list[Fit]:
    """``apgc fit`` and ``apgc bind`` of each object alone, in folders that are kept; those that do not fit are left out, and told."""
    found = []
    for origin, one in objects.items():
        place = folder / one.category / one.name
        place.mkdir(parents=True, exist_ok=True)
        arrays = {"points": one.points} | ({} if one.normals is None else {"normals": one.normals})
        (place / "cloud.npz").write_bytes(npz_bytes(arrays))
        fit = Fit(origin, one.category, one.name, place / "fitted", place / "bound")
        sampler, source = open_program(one.category)
        asked, to = Asked(source, Frame(up="z", front="x")), Folder(fit.fitted, pictures=False)
        told = write_fits(sampler, asked, to, [Item("cloud", File(place / "cloud.npz"))])[0]["objects"]
        if not told or told[0]["object"] is None:
            print(f"left out of what is mutated: {one.title}, to which no valid object fits", flush=True)
            continue
        print(f"fitted {one.title}: {told[0]['distance']:.2f} % of the diagonal off", flush=True)
        write_bindings(fit.fitted, Binding(BOUND, "mutual"), fit.bound)
        found.append(fit)
    return found


def mutants(
    fits: Sequence[Fit], known: tuple[str, ...], operations: tuple[str, ...], each: int, n: int, details: bool = False
) -> Clouds:
    """``each`` mutants of every fitted object, with the truth of the structure, bare or in the details of the original."""
    parts = []
    for fit in fits:
        job = apg.open_samples(fit.fitted).job
        step = Mutation(operations, each=each, sources=job.request.numbers)
        made = Samples(job.mutated(step, range(each)))
        worn = partial(dress, dressing=read_dressing(fit.bound)) if details else None
        points = sample_points(made.batch, Sampling(n, surface="outside"), made.joint_values(STATES), dress=worn)
        parts.append((made, points, f"{fit.category} {fit.name} mutant", fit.origin))
    return motion_clouds(parts, known)

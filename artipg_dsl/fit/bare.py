"""The primitives of candidates as fitting needs them, hundreds of times: without the parts that they belong to, and without words and links
unless these are asked for."""

from __future__ import annotations

from functools import cache, lru_cache

import numpy as np

from ..geometry.sites import SiteTable
from ..graph.expr import Expr, Scope
from ..graph.program import Site
from ..records import dataclass
from ..runtime.batch import Batch
from ..runtime.needs import pose_cells
from ..runtime.plan import Plan


@dataclass(frozen=True, slots=True, eq=False)
class _Layout:
    """What a plan tells of a ``site``: the outputs of its parameters, or numbers; its pose (13,), and which columns of it are outputs."""

    site: Site
    parameters: tuple[tuple[str, int | float], ...]
    pose: np.ndarray
    columns: tuple[tuple[int, int], ...]
    empty: SiteTable


def bare_tables(batch: Batch, *, linked: bool = False) -> list[SiteTable]:
    """The primitives at joint values 0; ``linked``: with their links."""
    every, found = np.arange(len(batch)), []

    @cache
    def owners(scope: Scope) -> tuple[np.ndarray, np.ndarray]:
        owner = batch.owner(scope)
        return owner, np.arange(len(owner)) - np.searchsorted(owner, every)[owner]

    links, values = cache(batch.link_numbers), batch._values
    for number, layout in enumerate(_layouts(batch.plan)):
        site, scope = layout.site, layout.site.scope
        owner, rank = owners(scope)
        size = len(owner)
        if not size:
            found.append(layout.empty)
            continue
        pose = np.empty((size, 13))
        pose[:] = layout.pose
        for column, output in layout.columns:
            pose[:, column] = values[output]
        params = {}
        for name, value in layout.parameters:
            params[name] = np.empty(size)
            params[name][:] = values[value] if isinstance(value, int) else value
        none = np.zeros(size, dtype=np.int64)
        link = links(scope, site.link) if linked else none
        rotation = np.ascontiguousarray(pose[:, :9]).reshape(-1, 3, 3)
        placed = rotation, pose[:, 9:12], pose[:, 12]
        primitive = layout.empty.primitive
        found.append(SiteTable(number, site.path, primitive, params, owner, *placed, link, none, none, rank))
    return found


@lru_cache(maxsize=8)
def _layouts(plan: Plan) -> list[_Layout]:
    def told(expr: Expr, scope: Scope) -> int | float:
        return float(expr.value) if expr.op == "const" else plan.outputs[expr, scope]

    found, none = [], np.zeros(0, dtype=np.int64)
    for number, site in enumerate(plan.program.sites):
        primitive = plan.program.primitives[site.primitive]
        parameters = tuple(zip(primitive.parameters, (told(e, site.scope) for e in site.parameters), strict=True))
        parameters = parameters or (("", 0.0),)
        pose, columns = np.zeros(13), []
        for column, expr in enumerate(pose_cells(site.pose)):
            output = told(expr, site.scope)
            if isinstance(output, int):
                columns.append((column, output))
            else:
                pose[column] = output
        params = {name: np.zeros(0) for name, _ in parameters}
        placed = np.zeros((0, 3, 3)), np.zeros((0, 3)), np.zeros(0)
        empty = SiteTable(number, site.path, primitive, params, none, *placed, none, none, none, none)
        found.append(_Layout(site, parameters, pose, tuple(columns), empty))
    return found

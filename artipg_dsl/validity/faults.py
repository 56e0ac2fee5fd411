"""All that makes objects invalid once their requirements hold: what their solids show."""

from __future__ import annotations

import numpy as np

from ..geometry.runs import distinct
from ..records import dataclass
from ..runtime.batch import Batch
from .apart import find_too_near
from .bodies import Pieces, gather
from .fault import Fault
from .floating import Solids, find_inverted
from .formulas import find_unsaid
from .gated import find_shut
from .loops import find_open
from .mass import find_crossed, find_weightless
from .stance import find_falling, name_feet
from .tree import Tree
from .validate import Collisions, find_collisions


@dataclass(frozen=True, slots=True)
class Faults:
    """Links that collide, and what else is wrong with the objects of a batch."""

    tree: Tree
    body: Pieces
    collisions: Collisions
    others: tuple[Fault, ...]

    def objects(self) -> np.ndarray:
        """Indices of the objects that have any."""
        return distinct(np.concatenate([self.collisions.objects(), *(fault.objects for fault in self.others)]))


def find_faults(batch: Batch, soon: bool = False) -> Faults:
    """Everything that is wrong with the objects of a batch; ``soon``: joints are moved only where nothing is wrong at rest."""
    tree = Tree(batch)
    body = gather(batch, tree.first, tree.turn, tree.shift)
    solids = Solids(tree, body)
    others = [
        *solids.missing(),
        *solids.degenerate(),
        *solids.floating(),
        *solids.find_unheld(),
        *find_inverted(tree),
        *find_weightless(batch),
        *find_crossed(batch),
        *find_unsaid(batch),
        *find_too_near(tree, body),
        *find_shut(tree),
        *find_open(tree),
    ]
    for statement, objects in zip(batch.program.stable, find_falling(tree, body), strict=False):
        example = name_feet(tree, body, int(objects[0])) if len(objects) and not soon else ""
        others.append(Fault(statement.message, objects, statement.where, example=example))
    found = tuple(fault for fault in others if len(fault.objects))
    lost = distinct(np.concatenate([np.zeros(0, dtype=np.int64), *(fault.objects for fault in found)]))
    return Faults(tree, body, find_collisions(batch, tree, body, lost if soon else None), found)

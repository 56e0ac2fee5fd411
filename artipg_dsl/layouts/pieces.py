"""What is seen of an object's links, the words that these and their parts bear, and where their joints are shut."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ..records import dataclass
from ..robot.model import RobotJoint
from ..robot.primitives import Shape
from ..robot.robots import Robots
from .words import Term


@dataclass(frozen=True, slots=True)
class Shut:
    """A joint as it is where the object is shut: ``value`` there, the ``sign`` of its axis by which it opens, and how far that is."""

    value: float
    sign: float
    reach: float

    @staticmethod
    def of(joint: RobotJoint) -> Shut:
        if joint.low is None or joint.high is None:
            return Shut(0.0, 1.0, 0.0)
        back = -joint.low > joint.high
        return Shut(joint.high if back else joint.low, -1.0 if back else 1.0, joint.high - joint.low)


class Pieces:
    """The meshes of object ``i`` at joint values 0, by link."""

    def __init__(self, robots: Robots, i: int, term: Term):
        self.robots, self.i, self.term = robots, i, term
        self.robot = robots.robot(i)
        self.first = int(robots.part_start[i])
        self.rows = slice(self.first, int(robots.part_start[i + 1]))  # of the table of parts
        self._words = robots.batch.program.vocabularies.get("semantic", ("",))

    def of(self, link: int) -> Iterator[tuple[int, Shape]]:
        """Part instance and mesh, in the object's frame, of what is seen of a link."""
        own = self.robot.links[link]
        for visual in own.visuals:
            shape = Shape(visual.name, visual.shape.vertices + own.origin, visual.shape.faces)
            yield int(visual.item.group.table.instance[visual.item.row]), shape

    def word(self, instance: int) -> str:
        """The word of a part."""
        k = int(self.robots.parts.semantic[self.first + instance])
        return self._words[k] if k else ""

    def part(self, link: int) -> int:
        """The part of the program that a link is, -1 for none."""
        row = int(self.robots.link_start[self.i]) + link
        return self.robots.batch.program.links[int(self.robots.links.definition[row])].part

    def moving(self) -> dict[int, str]:
        """The links that move in a way that has a class, and that class."""
        named = {
            j.child: self.term.parts.get(f"{self.robots.link_word(self.i, j.child)}/{j.kind}")
            for j in self.robot.joints
        }
        return {link: name for link, name in named.items() if name}

    def apart(self, link: int) -> list[int]:
        """The part instances on a link that have a class by their word alone."""
        return [k for k in dict.fromkeys(k for k, _ in self.of(link)) if self.word(k) in self.term.parts]

    def corners(self) -> np.ndarray:
        """All vertices (n, 3)."""
        return np.concatenate([shape.vertices for link in range(len(self.robot.links)) for _, shape in self.of(link)])

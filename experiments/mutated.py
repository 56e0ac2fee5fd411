"""Which points of an object move, told by real ones and by what is made from them: ``python -m experiments.mutated``."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from artipg_dsl.errors import UserError

from .clouds import Clouds
from .moving import Moving
from .mutants import fit_each, mutants
from .real import Real
from .study import Arm
from .training import command

FITS = "fits"  # the folder of fitted objects, beside the results


class Mutated(Moving):
    name = "mutated"
    what = "Which points of real objects move, told by few real ones and by mutants of them: mean IoU of what does and of what does not."
    arms = {
        "real": Arm(("real",)),
        "real and CPA": Arm(("real", "cpa")),
        "real and DPA + CPA": Arm(("real", "dpa,cpa")),
        "real and APA + DPA + CPA": Arm(("real", "apa,dpa,cpa")),
        "real and APA + DPA + CPA, in details": Arm(("real", "in details")),
    }
    pairs = [
        *((arm, "real") for arm in arms if arm != "real"),
        ("real and APA + DPA + CPA, in details", "real and APA + DPA + CPA"),
    ]
    each = 10  # mutants of each real object

    def sources(self, real: Clouds, objects: Sequence[Real], each: int, output: Path) -> dict[str, Clouds]:
        of = {title: int(origin) for title, origin in zip(real.names, real.origin, strict=True)}
        fits = fit_each({of[one.title]: one for one in objects if one.title in of}, output.parent / FITS)
        if not fits:
            raise UserError("no real object could be fitted, so there is nothing to mutate")
        made, n = {"real": real}, 2 * self.size
        for operations in ("cpa", "dpa,cpa", "apa,dpa,cpa"):
            made[operations] = mutants(fits, real.known, tuple(operations.split(",")), each, n)
        made["in details"] = mutants(fits, real.known, ("apa", "dpa", "cpa"), each, n, details=True)
        return made


if __name__ == "__main__":
    command(Mutated())

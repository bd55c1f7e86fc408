"""Loads of a run in the opposite direction."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from stiffcal.mistakes.runs.mistake import RunMistake, RunRead, Variant, scaled
from stiffcal.mistakes.suspect_kinds import SuspectKind


class LoadSign(RunMistake):
    """One component of the load, or all of it, in the opposite direction."""

    name = "load-sign"
    kind = SuspectKind.SIGN
    rank = 20

    def ways(self, read: RunRead) -> Iterator[Variant]:
        """Yield the run with components of its load reversed."""
        wrench = read.own.wrench
        for component, name in enumerate(("Fx", "Fy", "Fz", "Mx", "My", "Mz")):
            if np.any(wrench[:, component]):
                likely = f"{name} has the wrong sign: multiply it by −1"
                yield Variant(likely, -1.0, wrench=scaled(wrench, component, -1.0))
        if read.own.setup.moments_measured:
            likely = (
                "force and moment have the wrong sign, as of the force of the robot on its surroundings: multiply them "
                "by −1"
            )
            yield Variant(likely, -1.0, wrench=-wrench)
        forces = scaled(wrench, slice(0, 3), -1.0)
        yield Variant("the force has the wrong sign: multiply it by −1", -1.0, wrench=forces)

"""A joint's angle of a run in the opposite direction."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from stiffcal.mistakes.runs.mistake import RunMistake, RunRead, Variant, scaled
from stiffcal.mistakes.suspect_kinds import SuspectKind


class JointSign(RunMistake):
    """The angle of one joint in the opposite direction."""

    name = "joint-sign"
    kind = SuspectKind.SIGN
    rank = 23

    def ways(self, read: RunRead) -> Iterator[Variant]:
        """Yield the run with one joint's angle reversed."""
        joints, names = read.own.joints, read.chain.joint_names
        for joint in range(joints.shape[1]):
            if np.any(joints[:, joint]):
                name = names[joint] if joint < len(names) else str(joint + 1)
                likely = f"the angle of {name} has the wrong sign: multiply it by −1"
                yield Variant(likely, -1.0, joints=scaled(joints, joint, -1.0))

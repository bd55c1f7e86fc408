"""The sign of one length or angle of the robot file."""

from __future__ import annotations

from collections.abc import Iterator

from stiffcal.campaign.robot.geometry import chain_of
from stiffcal.fault_changes import InputChange
from stiffcal.mechanics.chain import Chain
from stiffcal.mistakes.inputs.mistake import AsRead, ChangeTexts, InputMistake, InputPart, TriedOn, Way


class RobotSign(InputMistake):
    """The other sign of one entry of a joint."""

    name = "robot-sign"
    part = InputPart.ROBOT
    tried_on = frozenset({TriedOn.ABSOLUTE_TABLE})
    rank = 43

    def ways(self, read: AsRead) -> Iterator[Way]:
        """Yield the robot with each entry negative that is positive, and the other way round."""
        robot = read.robot
        if robot is None or robot.convention is None:
            return
        for k, joint in enumerate(robot.joints):
            for key in ("a_m", "d_m", "alpha_deg"):
                value = getattr(joint, key)
                # half a turn is its own negative
                if value == 0.0 or (key == "alpha_deg" and abs(value) == 180.0):
                    continue
                changed = joint.model_copy(update={key: -value})
                joints = tuple(changed if j == k else entry for j, entry in enumerate(robot.joints))
                chain = chain_of(robot.model_copy(update={"joints": joints}), read.folder)
                yield Way(read.chosen, (joint.name,), (-value,), key, chain)

    def texts(self, change: InputChange, chain: Chain) -> ChangeTexts:
        """Return it in words."""
        (name,), (value,) = change.names, change.sizes
        place = f"joints[{chain.joint_names.index(name) + 1}] ({name}).{change.value}"
        mend = f"change the sign of {change.value} of joint {name}"
        return ChangeTexts(place, f"{change.value} = {value:g} of joint {name}", mend)

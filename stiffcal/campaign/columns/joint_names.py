"""Which columns of a table are the joints' angles, by names that are numbered."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

from stiffcal.campaign.columns.column_words import JOINT_STEMS, words_of

_ANGLES = (
    *("angle", "position", "pos", "actual", "act", "measured", "meas", "feedback"),
    *("winkel", "ist", "istwert", "istposition"),
    *("angulo", "angolo", "posicion", "posizione", "角度", "角", "位置"),
)
"""What may stand before a joint's name or behind its number ("Joint 1 angle")."""
_WORDS = f"(?:の?(?:{'|'.join(sorted(_ANGLES, key=len, reverse=True))}))+"
_ALONE, _AT_ITS_BEGIN, _AT_ITS_END = re.compile(_WORDS), re.compile(f"^{_WORDS}"), re.compile(f"{_WORDS}$")
_OF_ROBOT = re.compile(r"(?:jointstates?)?[a-z][a-z0-9]*joint|(?:[a-z][a-z0-9]*)?joint[a-z]")
_RANK_OF_ROBOT = 2 * len(JOINT_STEMS)  # after all stems, with words about them or not
_LONGEST_NAME = 300  # characters; a longer one is taken apart in the square of its length


_NAMED = (("shoulderpan", "shoulderlift", "elbow", "wrist1", "wrist2", "wrist3"), tuple("slurbt"))
"""Joints that have names, base to tip, of arms common in laboratories: Universal Robots (`ur_description`), Yaskawa."""


def numbered_joints(names: Sequence[str]) -> tuple[str, ...]:
    """Return the names that are numbered from 1 or 0 without a gap, three or more, with a stem that means joints.

    Also those of the arms in `_NAMED`, in the order of the arm: messages list them by the alphabet. Joints that are
    letters are all large or all small.

    Examples
    --------
    >>> numbered_joints(["t", "q2", "q1", "q3", "Fx"])
    ('q1', 'q2', 'q3')
    >>> numbered_joints([f"Joint {k} {what}" for k in (1, 2, 3) for what in ("torque", "angle")])
    ('Joint 1 angle', 'Joint 2 angle', 'Joint 3 angle')
    """
    named: dict[str, list[str]] = {}
    groups: dict[tuple[str, str], dict[int, str]] = {}
    for name in names:
        if len(name) > _LONGEST_NAME:
            continue
        bare = _AT_ITS_END.sub("", _AT_ITS_BEGIN.sub("", _joint_name(name)))
        named.setdefault(bare.replace("joint", ""), []).append(name)
        match = re.fullmatch(r"(|.*\D)0*(\d+)(\D*)", _joint_name(name))
        if match is not None:
            groups.setdefault((match[1], match[3]), {})[int(match[2])] = name
    for arm in _NAMED:
        if all(joint in named for joint in arm) and (found := _alike(arm, named)):
            return found
    ranked = [(_rank_of_joints(*key), group) for key, group in groups.items() if _are_joints(group)]
    known = [(rank, number) for number, (rank, _) in enumerate(ranked) if rank is not None]
    if not known:
        return ()
    if min(known)[0] == _RANK_OF_ROBOT and [rank for rank, _ in known].count(_RANK_OF_ROBOT) > 1:
        return ()  # which of two arms was measured no name states
    group = ranked[min(known)[1]][1]
    return tuple(group[number] for number in sorted(group))


def _alike(arm: Sequence[str], named: Mapping[str, Sequence[str]]) -> tuple[str, ...]:
    """Return the names of an arm's joints, base to tip; of letters in one case with the same about them: t may be time.

    Parameters
    ----------
    named : by joint, in small letters, the names that may be it, one at least.
    """
    if any(len(joint) > 1 for joint in arm):
        return tuple(named[joint][0] for joint in arm)
    for first in named[arm[0]]:
        for place, letter in enumerate(first):
            case = str.upper if letter.isupper() else str.lower
            own = tuple(f"{first[:place]}{case(joint)}{first[place + 1 :]}" for joint in arm)
            if all(name in named[joint] for name, joint in zip(own, arm, strict=True)):
                return own
    return ()


def _joint_name(name: str) -> str:
    """Return a name as `plain_name`, of a topic of joint states ("/joint_states/joint_1/position") what is its own."""
    words = [word for word in words_of(name)[0] if word != "states"]
    return "".join(word for word, last in zip(words, ["", *words], strict=False) if word != last or word.isdigit())


def _are_joints(numbered: Mapping[int, str]) -> bool:
    """Return whether names are numbered as joints are: three or more, from 1 or 0 without a gap."""
    return len(numbered) >= 3 and sorted(numbered) in (list(range(1, len(numbered) + 1)), list(range(len(numbered))))


def _rank_of_joints(before: str, behind: str) -> int | None:
    """Return how likely a name is a joint's, 0 the likeliest, by what stands about its number; None: it is none."""
    if before in ("", "第") and behind and not behind.isascii():  # 第1軸
        before, behind = behind, ""
    if behind and _ALONE.fullmatch(behind) is None:
        return None
    bare = _AT_ITS_BEGIN.sub("", before)
    for stem in (before, bare, _AT_ITS_END.sub("", before)):
        if stem in JOINT_STEMS:
            return JOINT_STEMS.index(stem) + len(JOINT_STEMS) * (bool(behind) or stem != before)
    # of messages, whose fields say that they are angles, the joint of a robot by its name: panda_joint1, joint_a1
    of_robot = _OF_ROBOT.fullmatch(bare)
    return _RANK_OF_ROBOT if of_robot is not None and (behind or bare != before) else None

"""Why a load state or a pass is not used: a code for what goes on from there, a text for people."""

from __future__ import annotations

from collections.abc import Sequence
from enum import StrEnum
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from stiffcal.arrays import Booleans


class SetAsideCode(StrEnum):
    """Causes for which a state or a pass is not used; the words are those of the store's column ``set_aside_code``."""

    NONE = ""
    """It is used."""
    EXCLUDED = "excluded"
    """The manifest excludes the row."""
    NOT_MEASURED = "not-measured"
    """Nothing that moves under load was read: the target was hidden or lost."""
    BUMPED = "bumped"
    """The reading contradicts its neighbours and repeats; the load was as written."""
    HELD_BRIEFLY = "held-briefly"
    """The load was reached, and left before it could be read."""
    COMMANDS_NOT_LOGGED = "commands-not-logged"
    """The controller was correcting, and no log holds by how much."""
    RODS_NOT_READ = "rods-not-read"
    """The rods gave no reading, so that the link's share is not known."""
    ONE_DIRECTION = "one-direction"
    """A friction pass without one the other way at its speed."""
    ANOTHER_STRETCH = "another-stretch"
    """A friction pass over another stretch of angle than the others at its speed."""

    CUT_OFF = "cut-off"
    """The force sensor or the motor's torque stayed at the end of its range."""
    DRIVEN_ONE_WAY = "driven-one-way"
    """A clamped joint that was not driven back: friction and backlash cannot be distinguished from the spring."""

    @property
    def short_text(self) -> str:
        """The cause for people, without the figures of one state."""
        return _SHORT_TEXTS[self]


_SHORT_TEXTS = {
    SetAsideCode.NONE: "",
    SetAsideCode.EXCLUDED: "excluded in the manifest",
    SetAsideCode.NOT_MEASURED: "the target was not measured",
    SetAsideCode.BUMPED: "outlier: differs from its neighbours and repeats",
    SetAsideCode.HELD_BRIEFLY: "dwell too short",
    SetAsideCode.COMMANDS_NOT_LOGGED: "correction of the controller not logged",
    SetAsideCode.RODS_NOT_READ: "no reading of the rods",
    SetAsideCode.CUT_OFF: "torque or force saturated",
    SetAsideCode.DRIVEN_ONE_WAY: "clamped joint driven one way only",
    SetAsideCode.ONE_DIRECTION: "moved in one direction only at this speed",
    SetAsideCode.ANOTHER_STRETCH: "different range of angle than the other passes",
}

OF_PASSES = (SetAsideCode.ONE_DIRECTION, SetAsideCode.ANOTHER_STRETCH)
"""The causes of friction passes; the others are those of load states."""


class SetAside(NamedTuple):
    """The cause and its text; both empty where the state is used."""

    code: SetAsideCode = SetAsideCode.NONE
    text: str = ""


IN_USE = SetAside()


def set_aside_columns(entries: Sequence[SetAside]) -> tuple[NDArray[np.str_], NDArray[np.str_]]:
    """Return (n,) codes and (n,) texts of n states.

    Examples
    --------
    >>> codes, texts = set_aside_columns([IN_USE, SetAside(SetAsideCode.EXCLUDED, "cable slipped")])
    >>> codes.tolist(), texts.tolist()
    (['', 'excluded'], ['', 'cable slipped'])
    """
    codes = np.array([entry.code.value for entry in entries], dtype=np.str_)
    return codes, np.array([entry.text for entry in entries], dtype=np.str_)


def any_code(codes: NDArray[np.str_], *wanted: SetAsideCode) -> Booleans:
    """Return (n,) True where the code is one of those given."""
    return np.isin(codes, [code.value for code in wanted])

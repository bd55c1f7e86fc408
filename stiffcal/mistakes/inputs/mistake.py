"""What a mistake is: what it changes, where it may be, how the data are without it, how it reads."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from enum import StrEnum
from functools import cached_property
from pathlib import Path
from typing import ClassVar

import numpy as np

from stiffcal.arrays import Floats, Integers
from stiffcal.campaign.robot.robot_file import RobotFile
from stiffcal.fault_changes import InputChange
from stiffcal.fault_codes import FaultCode
from stiffcal.measurements.load_states import LoadStates
from stiffcal.mechanics.chain import Chain
from stiffcal.mistakes.mistake import Mistake


class InputPart(StrEnum):
    """What of a campaign's input a mistake is in."""

    ANGLES = "angles"
    POSITIONS = "positions"
    ORIENTATIONS = "orientations"
    FRAMES = "frames"
    LOADS = "loads"
    DISPLACEMENTS = "displacements"
    ROWS = "rows"
    ROBOT = "robot"


class TriedOn(StrEnum):
    """Where a mistake is taken back, and what is looked at then."""

    ABSOLUTE_TABLE = "absolute-table"
    """All rows of a table of absolute places: frames of tracker and targets with which angles and places meet."""
    ABSOLUTE_ROWS = "absolute-rows"
    """Some of its rows: whether they meet the others, whose frames are known."""
    REFERENCES = "references"
    """The unloaded poses: whether kinematics meets the tracker, whose frame is stated or estimated."""
    ORIENTATIONS = "orientations"
    """The same poses, of which positions meet and orientations do not."""
    DISPLACEMENTS = "displacements"
    """A table of displacements: how much of them joint springs explain."""
    WORK = "work"
    """Loads and displacements or places that run against each other: how much joint springs explain."""


@dataclass(frozen=True)
class AsRead:
    """Data as the manifest and the robot file have them read, and where a mistake in them is looked for."""

    tried_on: TriedOn
    """What decides."""
    states: LoadStates
    """All n rows."""
    chain: Chain
    """The robot's kinematics."""
    rows: Integers
    """(r,) those that are looked at."""
    stated: Floats = field(default_factory=lambda: np.ones(0))
    """(L,) rad, the unit that the manifest states of the logged angles; 1 of a prismatic joint's length."""
    columns: tuple[str, ...] = ()
    """Names of the load's columns, 3 or 6; none where a mass is its source."""
    acts_on: str = "robot"
    """What the load acts on, as the manifest states it."""
    load_units: tuple[str, ...] = ()
    """Units of the load's forces and moments, as the manifest states them; none where a mass is its source."""
    robot: RobotFile | None = None
    """The robot file; None where none of its entries is doubted."""
    folder: Path = Path()
    """Where the robot file lies."""

    @classmethod
    def all_rows(cls, tried_on: TriedOn, states: LoadStates, chain: Chain, stated: Floats | None = None) -> AsRead:
        """Return states of which all are looked at."""
        rows = np.arange(len(states))
        return cls(tried_on, states, chain, rows, np.ones(0) if stated is None else stated)

    @cached_property
    def chosen(self) -> LoadStates:
        """The r rows that are looked at."""
        return self.states if np.array_equal(self.rows, np.arange(len(self.states))) else self.states.select(self.rows)

    @property
    def joints(self) -> Floats:
        """(r, L) logged, rad; m of prismatic joints."""
        return self.chosen.joints

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the L logged joints; their numbers where the robot file names others."""
        count = self.states.joints.shape[1]
        return self.chain.joint_names if len(self.chain.joint_names) == count else tuple(map(str, range(count)))

    def with_joint(self, joint: int, values: Floats) -> LoadStates:
        """Return the rows that are looked at with other readings (r,) of one joint, from 0."""
        joints = self.joints.copy()
        joints[:, joint] = values
        return self.with_joints(joints)

    def with_joints(self, joints: Floats) -> LoadStates:
        """Return the rows that are looked at with other joint readings, (r, L)."""
        return replace(self.chosen, joints=joints)


@dataclass(frozen=True)
class Way:
    """The data with one mistake taken back in one way."""

    states: LoadStates
    """The rows that are looked at, or those of them that are left without it."""
    names: tuple[str, ...] = ()
    """As of `InputChange`."""
    sizes: tuple[float, ...] = ()
    """As of `InputChange`."""
    value: str = ""
    """As of `InputChange`."""
    chain: Chain | None = None
    """The robot, where the mistake is in its file."""
    numbers: int = 0
    """How many numbers were chosen by the readings themselves: with these any data agree better."""


@dataclass(frozen=True)
class Adjustment:
    """A mistake whose size is one or more numbers that a fit finds."""

    names: tuple[str, ...]
    """As of `InputChange`."""
    start: Floats
    """(p,) where the search begins."""
    applied: Callable[[LoadStates, Floats], LoadStates]
    """The states with it taken back by numbers (p,)."""
    sizes: Callable[[Floats], tuple[float, ...]]
    """As of `InputChange`, of numbers (p,)."""


@dataclass(frozen=True)
class ChangeTexts:
    """A change in words."""

    place: str
    """Of the mistake in its file, as in "joint A2"; a load's key in the manifest is "wrench"."""
    words: str
    """What is tried, as in "with … they agree"."""
    mend: str
    """What to write or correct."""
    in_rows: str = ""
    """What is wrong where only some rows have the mistake."""


class InputMistake(Mistake[AsRead, Way]):
    """One mistake in what is read; `name` is the `InputChange.kind` of the change that takes it back."""

    part: ClassVar[InputPart]
    """What it is in."""
    tried_on: ClassVar[frozenset[TriedOn]]
    """Where it may be, and can be distinguished from all that is right."""
    code: ClassVar[FaultCode] = FaultCode.KINEMATICS_MISMATCH
    """The fault's."""

    def ways(self, read: AsRead) -> Iterator[Way]:
        """Yield the data with the mistake taken back, in each way whose size is known."""
        yield from ()

    def adjustments(self, read: AsRead) -> Iterator[Adjustment]:
        """Yield the ways whose size a fit has to find; asked for where one of `TriedOn.REFERENCES`."""
        yield from ()

    @abstractmethod
    def texts(self, change: InputChange, chain: Chain) -> ChangeTexts:
        """Return a change of this kind in words.

        Parameters
        ----------
        change : with the names, sizes and value of one of the ways. chain : the robot.
        """

    def is_in_manifest(self, change: InputChange) -> bool:
        """Return whether the manifest is wrong, where all rows have it; else the table, or the robot file."""
        return False

    def is_distinct(self, read: AsRead, taken: TakenBack) -> bool:
        """Return whether the data distinguish it from an effect that is alike; asked of what explains them best."""
        return True

    def as_known(self, best: Scored, tried: Sequence[Scored]) -> InputChange:
        """Return the change, less what the data leave open of it.

        Parameters
        ----------
        best : the change, and what it explains. tried : all changes.
        """
        return best.taken.change


@dataclass(frozen=True)
class TakenBack:
    """A mistake, and the data without it."""

    mistake: InputMistake
    change: InputChange
    """With which it is taken back."""
    states: LoadStates
    """The rows that are looked at, or those of them that are left."""
    chain: Chain
    """The robot."""
    numbers: int = 0
    """As of `Way`."""


@dataclass(frozen=True)
class Scored:
    """A mistake that was taken back, and what the data say to that."""

    score: float
    """What decides where it was tried."""
    taken: TakenBack

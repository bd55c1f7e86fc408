"""What a kind of experiment gives the diagnosis: its readings as rows of equations that models are fitted to.

The search for missing effects, its judge and its words are the same for all kinds; what differs is in here.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

from stiffcal.arrays import Floats, Integers
from stiffcal.estimation.parameters import Parameter
from stiffcal.estimation.rows import Rows
from stiffcal.identification.answers.fit_results import IdentifiedParameter
from stiffcal.identification.fitting.regressors import Regressor, RegressorMaker
from stiffcal.identification.readings.search_subject import SearchSubject
from stiffcal.model.assembled.composite import CompliantRobot
from stiffcal.model.effect import Effect, Place


@dataclass(frozen=True)
class RowNoise:
    """The noise of rows."""

    dof: float
    """Degrees of freedom behind it."""
    source: str
    """As `NoiseSource`."""


@dataclass(frozen=True)
class RowCovariate:
    """Something logged that a remainder may follow."""

    name: str
    """As in `ResidualDependence`."""
    value: Floats
    """(k,) of each row."""
    words: str
    """The dependence in words."""


@dataclass(frozen=True)
class RowFit:
    """A model fitted to k rows."""

    robot: CompliantRobot
    """The model with the estimated values."""
    rows: Rows
    """About the estimates: the free parameters by their full names, then what else is fitted with them; of one
    component of k rows, in the measure's unit, free constants not taken out.
    """
    noise: RowNoise | None
    """None where the noise is not known; ``sigma`` is then the residuals' own size."""
    sigma: Floats
    """(k,) standard uncertainty of each row, in the measure's unit."""
    constant: Integers
    """(k,) number of the free constant that a row carries; −1 where it carries none."""
    fold: Integers
    """(k,) number of what is left out together."""
    run: Integers
    """(k,) number of the row's run."""
    maker: RegressorMaker
    """Makes the regressors of effects."""
    parameters: tuple[Parameter, ...]
    """What was found of each parameter …"""
    identified: tuple[IdentifiedParameter, ...]
    """… and as ``identify`` answers it."""

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Full names of the free parameters, which are the first unknowns."""
        values = self.robot.values()
        return tuple(name for name in self.rows.unknowns.names if name in values)


@dataclass(frozen=True)
class RowCourse:
    """In which order k rows were read, and which of them err together."""

    joint: Integers
    """(k,) from 1."""
    time: Floats
    """(k,) s since the joint's first reading."""
    direction: Floats
    """(k,) of motion, 1 or −1."""
    group: Integers
    """(k,) number of the pass, or of the piece of other motion: each may err in a way of its own."""

    def select(self, rows: Integers) -> RowCourse:
        """Return that of some rows."""
        return RowCourse(self.joint[rows], self.time[rows], self.direction[rows], self.group[rows])


@dataclass(frozen=True)
class UsualMotion:
    """How a joint moves and resists in all rows."""

    torque: float
    """N·m, rms, what weight, inertia and zeros can make taken out."""
    speed: float
    """rad/s, rms."""


class RowProblem(ABC):
    """Rows of one kind of experiment that share parameters with each other and with no other rows."""

    measure: str
    """What is measured, as in `Rms`: "torque"."""
    unit: str
    """SI, of the measure."""
    subject: SearchSubject
    """What is searched, in words."""
    folds_in_words: str
    """What is left out in turn: "speeds"."""
    index: Integers
    """(k,) number of each row among all rows of the campaign, as in `DrawnRows`."""
    joints: tuple[int, ...]
    """The joints whose rows they are, from 1."""

    @property
    @abstractmethod
    def robot(self) -> CompliantRobot:
        """The present model, as far as these rows show it."""

    @abstractmethod
    def fit(self, robot: CompliantRobot) -> RowFit:
        """Fit a model to the rows."""

    @abstractmethod
    def places(self, effect: Effect) -> list[Place]:
        """Return the places of an effect that these rows could show; empty for effects of another kind."""

    @abstractmethod
    def lacking(self, effect: Effect, place: Place) -> str | None:
        """Return the data missing to determine an effect at a place, or None."""

    @abstractmethod
    def covariates(self) -> list[RowCovariate]:
        """Return what a remainder may follow."""

    @abstractmethod
    def course(self) -> RowCourse:
        """Return in which order the rows were read, and which err together."""

    @abstractmethod
    def group_in_words(self, group: int) -> str:
        """Return what is numbered in `RowCourse.group`, in words."""

    @abstractmethod
    def usual(self, joint: int) -> UsualMotion:
        """Return how a joint, from 1, moves and resists."""

    def with_time_for_temperature(self, effect: Effect, place: Place, shape: Mapping[str, float]) -> Regressor | None:
        """Return an effect's regressor with the time in place of the temperature; None where it follows none."""
        return None


def merged_lacking(reasons: Mapping[str, list[str]]) -> list[tuple[str, str]]:
    """Return (effect, what it needs), reasons of several places joined."""
    return [(effect, "; ".join(dict.fromkeys(texts))) for effect, texts in reasons.items()]

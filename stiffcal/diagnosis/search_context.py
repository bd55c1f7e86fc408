"""What a search for missing effects works on: it fits models, tries the catalogue on each, and keeps what it found."""

from __future__ import annotations

import time
from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Generic

from stiffcal.diagnosis.candidates import Candidate, impossible_configuration
from stiffcal.diagnosis.judge import fitted_values
from stiffcal.diagnosis.results import ResidualDependence, UntestableEffect
from stiffcal.diagnosis.scan import Scan, Trial
from stiffcal.diagnosis.search_results import F, Pace, S
from stiffcal.model.composite import CompliantRobot, PlacedEffect
from stiffcal.model.effect import ParameterRole
from stiffcal.model.no_balance import NoBalanceError


class NoBalanceWithError(Exception):
    """The robot finds no balance with a candidate as fitted."""

    def __init__(self, name: str) -> None:
        super().__init__(name)
        self.name = name


@dataclass(frozen=True)
class SearchContext(ABC, Generic[S, F]):
    """What a search works on, and the scans made so far: the catalogue is tried once per model."""

    looks: dict[frozenset[str], S] = field(default_factory=dict, kw_only=True)
    without_balance: set[str] = field(default_factory=set, kw_only=True)
    """Names of candidates with whose fitted values the robot finds no balance: they are no explanation."""
    seconds: list[float] = field(default_factory=list, kw_only=True)
    basic: frozenset[str] = field(default=frozenset(), kw_only=True)
    """Names of effects on top of which all others come: of a place without any effect they are tried alone."""

    @abstractmethod
    def fit(self, robot: CompliantRobot) -> F:
        """Fit a model."""

    @abstractmethod
    def scan(self, fit: F, candidates: Sequence[Candidate], like: F | None = None) -> S:
        """Try candidates as additions to a fit.

        Parameters
        ----------
        fit : of the model.
        candidates : who is tried.
        like : a fit whose noise is taken in place of the fit's own.
        """

    @abstractmethod
    def fit_of(self, scan: S) -> F:
        """Return the fit that a scan is of."""

    @abstractmethod
    def candidates(self, robot: CompliantRobot) -> tuple[list[Candidate], list[UntestableEffect]]:
        """Return the effects that can be added to a model, and those that cannot, with the reason."""

    @abstractmethod
    def follows(self, scan: S) -> list[ResidualDependence]:
        """Return what the residual of a scan's model follows, largest share first."""

    def look(self, robot: CompliantRobot) -> S:
        """Fit a model and try every candidate as an addition to it."""
        key = _key_of(robot)
        if key not in self.looks:
            fit = self.fit(robot)
            listed, _ = self.candidates(fit.robot)
            candidates = [candidate for candidate in listed if candidate.name not in self.without_balance]
            start = time.perf_counter()
            self.looks[key] = self.scan(fit, candidates)
            self.seconds.append(time.perf_counter() - start)
        return self.looks[key]

    def look_with(self, robot: CompliantRobot, *trials: Trial) -> S:
        """Add candidates to a model, and look at it.

        Raises
        ------
        NoBalanceWithError : the robot finds no balance with the last of them: of an effect that was added before and
            makes a robot that cannot be, else of the last.
        """
        start = robot
        for trial in trials:
            robot = with_trial(robot, trial)
        try:
            return self.look(robot)
        except NoBalanceError:
            present = next((look.fit.robot for look in self.looks.values()), start)
            cause = impossible_configuration(start, present) or trials[-1].candidate.name
            raise NoBalanceWithError(cause) from None

    def error_alone(self, robot: CompliantRobot, trial: Trial) -> S:
        """Return a scan of a model with a candidate that holds the model's own error, and need not hold any trials.

        It is not kept: of a model that is compared once, trying all candidates next to it is of no use.

        Raises
        ------
        NoBalanceWithError : the robot finds no balance with the candidate.
        """
        with_it = with_trial(robot, trial)
        if _key_of(with_it) in self.looks:
            return self.look(with_it)
        try:
            return self.scan(self.fit(with_it), [])
        except NoBalanceError:
            raise NoBalanceWithError(trial.candidate.name) from None

    def exclude(self, name: str) -> None:
        """Leave a candidate out of this search, and out of the looks so far: they are not made again for it."""
        self.without_balance.add(name)
        for key, scan in self.looks.items():
            left = tuple(trial for trial in scan.trials if trial.candidate.name != name)
            share = sum(trial.n_variants for trial in left) / max(sum(trial.n_variants for trial in scan.trials), 1)
            self.looks[key] = replace(scan, trials=left, n_tried=max(round(scan.n_tried * share), 1))

    def pace(self) -> Pace:
        """Return the number of fits tried so far, and their rate."""
        scans: list[Scan] = list(self.looks.values())
        return Pace(
            len(scans), sum(len(scan.trials) for scan in scans), sum(scan.n_tried for scan in scans), sum(self.seconds)
        )


def _key_of(robot: CompliantRobot) -> frozenset[str]:
    """Return what distinguishes a model from others of the same search."""
    return frozenset(_label_of(placed) for placed in robot.placed)


def _label_of(placed: PlacedEffect) -> str:
    """Return effect, form and place."""
    return " ".join((placed.effect.name, placed.place.label, *(spec.symbol for spec in placed.effect.parameters)))


def with_trial(robot: CompliantRobot, trial: Trial) -> CompliantRobot:
    """Return the model with a candidate added, its shape where the scan found it best."""
    values = {
        s: v for s, v in fitted_values(trial).items() if trial.candidate.effect.spec(s).role is ParameterRole.NONLINEAR
    }
    added = PlacedEffect(trial.candidate.effect, trial.candidate.place, values)
    # What the newcomer includes goes: its part is in the whole.
    kept = tuple(
        placed
        for placed in robot.placed
        if not (placed.place == trial.candidate.place and placed.effect.name in trial.candidate.effect.includes)
    )
    return replace(robot, placed=(*kept, added))


def without(robot: CompliantRobot, candidate: Candidate, present: CompliantRobot | None = None) -> CompliantRobot:
    """Return the model without an effect; what the effect had replaced in ``present`` is put back."""
    kept, included = [], set(candidate.effect.includes)
    for placed in robot.placed:
        if placed.effect.name == candidate.effect.name and placed.place == candidate.place:
            included.update(placed.effect.includes)
        else:
            kept.append(placed)
    dependent = tuple(
        placed
        for placed in (present.placed if present is not None else ())
        if placed.place == candidate.place and placed.effect.name in included
    )
    return replace(robot, placed=(*dependent, *kept))

"""What a search for missing effects found."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Generic, TypeAlias, TypeVar

from stiffcal.diagnosis.candidates import Candidate
from stiffcal.diagnosis.deletions import Rival
from stiffcal.diagnosis.explained import Explained
from stiffcal.diagnosis.judge import Judgement, LackOfFit
from stiffcal.diagnosis.load_scan import LoadScan
from stiffcal.diagnosis.results import UntestableEffect
from stiffcal.diagnosis.scan import ModelFit, Scan
from stiffcal.diagnosis.setting_results import ContradictedSetting, WrongGeometry
from stiffcal.identification.fit import Fit


@dataclass(frozen=True)
class MissingEffect:
    """An effect that is missing."""

    candidate: Candidate
    """Which, and where."""
    alternatives: tuple[Candidate, ...]
    """Candidates that these data cannot distinguish from it."""
    judgement: Judgement
    """How sure."""
    rivals: tuple[Rival, ...] = ()
    """Candidates, itself among them, between which single poses decide; empty where none does."""
    form: tuple[tuple[str, float], ...] = ()
    """Symbols and values of the form of the law that fits best; empty where it is the catalogue's."""
    cosines: tuple[float, ...] = ()
    """Of each alternative: the cosine of its displacements, as fitted, with the effect's own, beyond what the model
    absorbs (`naming.displacement_cosine`).
    """


S = TypeVar("S", bound=Scan)
F = TypeVar("F", bound=ModelFit)


@dataclass(frozen=True)
class SearchOf(Generic[S, F]):
    """What was found, by a search of one kind of scan and of fit."""

    first: S
    """The scan of the present model."""
    found: tuple[MissingEffect, ...]
    """Effects to add, in order; empty where nothing is missing, where what was found explains too little, or where the
    one that matters most is undecided. Lesser ones that are undecided are not among them.
    """
    tried: tuple[MissingEffect, ...]
    """The set that was reached, also where it explains too little."""
    final: F
    """The fit with ``tried`` added."""
    final_scan: S
    """The last scan, of ``final``."""
    before: LackOfFit | None
    """Residuals against noise without ``tried``; None where the noise is not known."""
    after: LackOfFit | None
    """Residuals against noise with ``tried``; None where the noise is not known."""
    explained: Explained
    """Share of the avoidable error that goes with ``tried``, with its 95 % interval over poses."""
    unexplained: bool
    """Something is left that nothing accounts for."""
    not_tried: tuple[UntestableEffect, ...]
    """Effects that these data cannot test."""
    pace: Pace
    """How much was tried, and how fast."""
    undecided: tuple[Rival, ...] = ()
    """Candidates for the effect that matters most, where single poses decide between them or too many look alike."""
    undecided_next: tuple[Rival, ...] = ()
    """The same for a lesser effect: it stays open until those that are named are in the model."""
    contradicted: tuple[ContradictedSetting, ...] = ()
    """What the model file sets and the data contradict; the search is without these settings."""
    could_be: tuple[Candidate, ...] = ()
    """Where nothing is named and something is left: effects of which each alone fits all poses down to noise, while the
    poses are too few to judge any of them in one left out.
    """
    wrong_geometry: WrongGeometry | None = None
    """How wrong the robot file is, where absolute places contradict it."""
    without_balance: bool = False
    """Effects were found without one of which the robot has no equilibrium: whether each is needed cannot be judged."""
    many_laws: bool = False
    """``tried`` has so many different laws that it would explain any error: none of them is named."""


Search: TypeAlias = SearchOf[LoadScan, Fit]
"""Of load states."""


@dataclass(frozen=True)
class Pace:
    """How much a search tried."""

    models: int
    """Number of models to which the catalogue was tried as an addition."""
    candidates: int
    """Effects at places, all models together."""
    regressors: int
    """The same with every shape."""
    seconds: float
    """Spent on them, the models' own fits not counted."""

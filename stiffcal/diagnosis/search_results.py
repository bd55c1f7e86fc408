"""What a search for missing effects found."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Generic, TypeVar

from stiffcal.diagnosis.candidates import Candidate
from stiffcal.diagnosis.deletions import Rival
from stiffcal.diagnosis.explained import Explained
from stiffcal.diagnosis.judge import Judgement, LackOfFit
from stiffcal.diagnosis.results import UntestableEffect
from stiffcal.diagnosis.scan import ModelFit, Scan


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
    could_be: tuple[Candidate, ...] = ()
    """Where nothing is named and something is left: effects of which each alone fits all poses down to noise, while the
    poses are too few to judge any of them in one left out.
    """
    without_balance: bool = False
    """Effects were found without one of which the robot has no equilibrium: whether each is needed cannot be judged."""


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

"""What `plan` answers: the runs to measure and what they would bring."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

from stiffcal.document_arrays import Matrix, Vector
from stiffcal.documents import NOT_IN_DOCUMENT, CommandResult, Number, OrAbsent
from stiffcal.identification.answers.observability import ObservabilityIndices


@dataclass(frozen=True, slots=True, kw_only=True)
class RunToMeasure:
    """A run to measure: a pose, read unloaded, at every load step, and unloaded again."""

    id: str
    """The run's id, in the order of measuring."""
    joints: Vector
    """(L,) rad, logged angles."""
    wrench: Matrix
    """(K, 6) N, N·m, base axes, at the load point: the load steps in order."""
    minutes: float
    """How long it takes, as plan.toml states the times."""
    minutes_per_state: float
    """How long each of its load steps and unloaded states takes, likewise."""
    approach: Matrix
    """(V, L) rad, poses to drive through on the way from the run before; empty where the direct joint move is free."""
    moved_joint: OrAbsent[int] = None
    """Of clamped robots the number of the joint that is driven, from 1."""
    turn: OrAbsent[float] = None
    """How far its motor is driven to and fro at most, rad at the joint's side."""
    rank: int
    """Its place in the order of what runs bring, from 1: what to measure first if time is short."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ExpectedParameter:
    """How well a parameter would be known."""

    name: str
    """The parameter's full name."""
    unit: str
    """Of ``value``."""
    value: float
    """The value that the plan is made for: fitted, of model.toml, or typical."""
    assumed: bool
    """True where neither a fit nor model.toml gives the value, and a typical one stands in."""
    half_width: Number
    """Expected half width of the 95 % interval of the value; null where the parameter would not be identified."""
    relative: Number
    """The same relative to the value, of geometry and frames to the typical size of their errors; null where the
    parameter would not be identified.
    """
    from_geometry: Number
    """Share of the robot file's tolerances of lengths and angles in the variance, 0 to 1, which more runs of one kind
    do not reduce; null where the parameter would not be identified.
    """
    identified: bool
    """False where no possible run brings enough on it."""


@dataclass(frozen=True, slots=True, kw_only=True)
class LossOfRun:
    """A parameter of which one run brings more than half of the information: without its log it is hardly known."""

    parameter: str
    """The parameter's full name."""
    run: str
    """The run's id."""
    relative: Number
    """Relative half width of the 95 % interval without this run; null where nothing else identifies the parameter."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Separation:
    """How far a plan separates two models, were one of them true."""

    truth: str
    """The effect and its place that is taken as true."""
    rival: str
    """The effect and its place that is fitted in its stead."""
    chi_square: float
    """By how much the rival's weighted sum of squares would be larger than the noise's, refitted to the same runs."""
    needed: float
    """χ² with which `diagnose` calls them alike in five of a hundred campaigns at most."""
    distinguished: bool
    """Whether ``chi_square`` is as large as that."""
    times: Number
    """How often each run of the plan would have to be measured for that, 1 where the plan suffices; null where
    repeats do not help.
    """


@dataclass(frozen=True, slots=True, kw_only=True)
class GainPoint:
    """What the plan has brought after its first runs, the most informative first."""

    runs: int
    """Number of runs."""
    minutes: float
    """Time for these, warm-up included."""
    worst_relative: Number
    """Largest relative half width of the 95 % intervals of the parameters that the plan identifies and is made for:
    those that plan.toml names; where it names none, all but knees and bands."""


@dataclass(frozen=True, slots=True, kw_only=True)
class AnotherHour:
    """What another hour of measuring would bring after all runs of the plan."""

    runs: int
    """Further runs in an hour, at least one."""
    worst_relative: Number
    """Largest relative half width of the 95 % intervals after these; null where it is not known."""
    smaller: float
    """By which share of itself the largest half width becomes smaller, 0 to 1."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Remedy:
    """What would identify a parameter that these means do not."""

    parameter: str
    """Its full name."""
    means: list[str]
    """Other means, each of which alone suffices, in words; empty where none of those that were tried does."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PlannedGoal:
    """One of several goals of a plan."""

    goal: str
    """"stiffness", "look-alikes", "region", or the path's file."""
    weight: float
    """Its share in the mix, 0 to 1."""
    efficiency: float
    """Of the plan in this goal alone, as `PlanResult.efficiency`."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PlanResult(CommandResult):
    """Answer of ``plan``."""

    schema: Literal["stiffcal/plan/1"] = "stiffcal/plan/1"
    experiment: Literal["load", "absolute", "clamped"]
    """What is measured: load runs, absolute places, or a clamped robot's driven joints."""
    criterion: Literal["determinant", "worst", "prediction", "rivals", "mix"]
    """What the choice of runs minimises."""
    efficiency: float
    """Ratio of variances, 0 to 1: bound of the relaxed optimum over this plan (Kiefer and Wolfowitz, 1960)."""
    candidates: int
    """Pairs of a drawn pose and a load that the runs were chosen from, before joint angles were refined."""
    values_from: str
    """Where the model's values are from, in words."""
    minutes: float
    """Time for the whole plan, warm-up included."""
    warm_up_minutes: float
    """Of these before the first run."""
    runs: list[RunToMeasure]
    """In the order of measuring."""
    parameters: list[ExpectedParameter]
    """Of the model, in its order."""
    blocked_moves: list[list[str]]
    """Pairs of successive runs between which no joint move stays out of the keep-out boxes and above the lowest height,
    not through another pose either.
    """
    rests_on_one_run: list[LossOfRun]
    """Parameters of which one run brings more than half of the information."""
    gain: list[GainPoint]
    """After 1, 2, … runs."""
    not_identified: list[str]
    """Parameters that no possible run identifies with these means."""
    prediction_half_width_m: OrAbsent[float] = None
    """Expected 95 % half width of the predicted deflection (of absolute places: place), rms over the poses that
    ``predicted_at`` names, m. What is not identified is taken as exact.
    """
    predicted_at: OrAbsent[str] = None
    """The path's file, "region", or "random poses"."""
    goals: OrAbsent[list[PlannedGoal]] = None
    """Where the plan has several goals."""
    another_hour: OrAbsent[AnotherHour] = None
    """What another hour would bring; absent where nothing is identified."""
    remedies: OrAbsent[list[Remedy]] = None
    """Of every parameter in ``not_identified``."""
    observability: OrAbsent[ObservabilityIndices] = None
    """Indices of the poses, of absolute places."""
    file: OrAbsent[str] = None
    """The run sheet that was written."""
    separations: OrAbsent[list[Separation]] = None
    """Of every ordered pair of rival models, where a plan separates some."""
    program: OrAbsent[str] = None
    """The robot program that was written."""
    folder: OrAbsent[str] = None
    """The campaign folder that was made ready for the logs."""
    files: OrAbsent[list[str]] = None
    """What was written into it."""
    joint_names: Annotated[tuple[str, ...], NOT_IN_DOCUMENT]
    """Of the logged joints, L of them."""

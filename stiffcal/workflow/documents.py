"""What the commands answer with ``--json``, typed; SI units, null for what is not known.

Documents may hold more than stands here: what does stand here is what other programs may rely on.
"""

from __future__ import annotations

from typing import Literal, NotRequired

from typing_extensions import TypedDict

from stiffcal.diagnosis.suspects.result import Suspect
from stiffcal.experiments.clamped.results import ClampedSection
from stiffcal.experiments.friction.results import FrictionSection
from stiffcal.experiments.results import HeldoutSection
from stiffcal.workflow.body_documents import CartesianStiffness, JointByItself
from stiffcal.workflow.document_types import Fault, Model, Number, Origin, Rms, Threshold, Where
from stiffcal.workflow.link_documents import Coupling, MeasuredLink


class Parameter(TypedDict):
    """An identified parameter; value null where these data cannot tell it. ``stiffness*`` stand with compliances."""

    name: str
    effect: str
    where: Where
    value: Number
    std: Number
    interval: list[Number] | None
    unit: str
    fixed: bool
    identifiable: bool
    stiffness: NotRequired[Number]
    stiffness_std: NotRequired[Number]
    stiffness_interval: NotRequired[list[Number] | None]
    above_noise: NotRequired[bool]


class Ambiguity(TypedDict):
    """Parameters that cannot be told apart, why, and what of them is known."""

    parameters: list[str]
    known: str | None
    reason: str


class Rejected(TypedDict):
    """A load state that was not used."""

    run: str
    row: int
    why: str


class TwoForms(TypedDict):
    """A compliance in the matrix form and in dual quaternions, rad/(N·m); and by paper 003's unweighted eq. 35."""

    name: str
    matrix: float
    dual_quaternion: float
    unweighted_in_metres: Number
    unweighted_in_millimetres: Number


class DualQuaternions(TypedDict):
    """Joint springs identified in both forms (``identify --dual-quaternions``)."""

    largest_relative_difference: float
    parameters: list[TwoForms]


class Identify(TypedDict):
    """Answer of ``identify``."""

    schema: Literal["stiffcal/identify/1"]
    warnings: list[str]
    model: Model
    parameters: list[Parameter]
    n_states: int
    n_runs: int
    rms: Rms
    noise: Rms | None
    noise_source: Literal["repeats", "manifest", "none"]
    reduced_chi2: Number
    condition: Number
    not_identifiable: list[Ambiguity]
    rejected: list[Rejected]
    suspects: NotRequired[list[Suspect]]
    expected_rms: Rms | None
    expected_error: str
    links: NotRequired[list[MeasuredLink]]
    coupling: NotRequired[Coupling]
    dual_quaternions: NotRequired[DualQuaternions]
    joints_by_themselves: NotRequired[list[JointByItself]]
    cartesian_stiffness: NotRequired[list[CartesianStiffness]]
    n_readings: NotRequired[int]
    clamped: NotRequired[ClampedSection]
    friction: NotRequired[FrictionSection]
    origin: NotRequired[Origin]


class Part(TypedDict):
    """The error in a part of the data."""

    label: str
    low: Number
    high: Number
    n: int
    rms: Rms
    max: Rms
    zero_model: NotRequired[Rms]


class Worst(TypedDict):
    """A state with a large residual."""

    run: str
    row: int
    residual_m: float


class Validate(TypedDict):
    """Answer of ``validate``."""

    schema: Literal["stiffcal/validate/1"]
    warnings: list[str]
    scheme: str
    rms: Rms
    max: Rms
    noise: Rms | None
    relative: Rms
    zero_model: Rms
    by_run: list[Part]
    by_direction: list[Part]
    by_load: list[Part]
    by_branch: list[Part]
    by_joint_angle: list[Part]
    by_body: NotRequired[list[Part]]
    by_joint: NotRequired[list[Part]]
    clamped: NotRequired[HeldoutSection]
    friction: NotRequired[HeldoutSection]
    worst: list[Worst]
    suspects: NotRequired[list[Suspect]]
    passed: bool
    failed: list[str]
    not_judged: list[str]
    checks: list[Threshold]
    origin: NotRequired[Origin]


class Error(TypedDict):
    """Answer of any command with exit code 2 or 3; ``others`` where there are more faults."""

    error: Fault
    others: NotRequired[list[Fault]]

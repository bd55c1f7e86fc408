"""What a report is made of: the finished results of the other rooms, as plain arrays and documents.

The report draws results and computes none: every number on its pages stands here already, in SI units. `gathering/`
fills this in and leaves out what does not exist (``None`` or an empty tuple); the report then leaves that page out and
gives the reason.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from stiffcal.arrays import Booleans, Floats, Integers
from stiffcal.campaign.manifest.report_settings import ReportSettings
from stiffcal.compensation.map_result import MapResult
from stiffcal.compensation.predict_result import LoadPath
from stiffcal.diagnosis.answers.results import DiagnoseResult, EarlierDiagnosis, EffectEvidenceSummary
from stiffcal.identification.answers.before_after import BeforeAfter
from stiffcal.identification.answers.fit_results import IdentifiedParameter
from stiffcal.ingest.results import IngestResult
from stiffcal.measurements.rms import Rms
from stiffcal.measurements.state_measures import StateMeasure
from stiffcal.model.summary import EffectAt
from stiffcal.presentation.values import Page, Table
from stiffcal.report.compensation_content import WithAndWithout
from stiffcal.report.joint_curves import JointPicture
from stiffcal.report.link_pictures import LinkPicture
from stiffcal.report.pictures_of_fit import PictureOfFit
from stiffcal.report.provenance_content import ReportInstrument, ReportProvenance
from stiffcal.results.history_results import HistoryResult
from stiffcal.results.identify_result import IdentifyResult
from stiffcal.results.validate_result import ValidateResult
from stiffcal.validation.schemes import held_out

Strings = NDArray[np.str_]

BRANCHES = ("loading", "unloading", "")


@dataclass(frozen=True)
class ReportRun:
    """One run: a pose in which loads were applied."""

    name: str
    """The run's id."""
    joints: Floats
    """(L,) rad, the logged joint angles, mean over the run."""
    stick: Floats | None = None
    """(K, 3) m in base axes: base origin, joint origins from base to wrist, flange (K = J + 2)."""
    target: Floats | None = None
    """(3,) m in base axes: the measured point, where residual arrows start; None where not known."""
    holdout: bool = False
    """True where no fit uses it."""
    tags: tuple[str, ...] = ()
    """The manifest's words for the run."""
    kind: str = "load"
    """The name of its kind of experiment."""
    measures: StateMeasure | None = StateMeasure.DISPLACEMENT
    """What is measured in its states; of places each row is a run."""


@dataclass(frozen=True)
class SetAsideRows:
    """States that were not used, with the reason."""

    run: str
    """The run's name, "" where it concerns a whole source."""
    rows: tuple[int, ...]
    """Data rows of the table or numbers of the holds, from 1."""
    why: str
    """In words."""


@dataclass(frozen=True)
class ReportStates:
    """n load states, grouped by run and in the order in which they were reached."""

    run: Integers
    """(n,) index into ``ReportContent.runs``."""
    force: Floats
    """(n, 3) N, base axes, what the surroundings do to the robot, less the force in the run's reference state."""
    load: Floats
    """(n,) N, the magnitude that loads are sorted by."""
    direction: Strings
    """(n,) label of the load's direction within its run, e.g. "1" or "+x"; opposite directions are two labels; "" for a
    state without load at the run's start. Labels are drawn apart by colour and marker.
    """
    branch: Strings
    """(n,) "loading", "unloading" or "" where there is none (single states, reference)."""
    measured: Floats
    """(n, 3) m or (n, 6) m, rad, base axes: displacement since the run's reference; NaN where not measured."""
    predicted: Floats
    """The same shape; the fit's model at these states, the run's own offset (the reference reading's error) added, so
    that measured minus predicted is the fit's residual.
    """
    predicted_heldout: Floats | None = None
    """The same shape, the run's offset added; each run by a fit without its pose; None where not validated.
    """
    set_aside: Strings | None = None
    """(n,) why a state was not used, "" where it was. Such states are drawn as crosses."""
    reference: NDArray[np.bool_] | None = None
    """(n,) True for the run's reference state; it carries no information of its own."""
    along: Floats | None = None
    """(n, 3) unit vectors along which alone displacements were read (gauges, a load-displacement device), base axes;
    None where all components were. Displacements across it are zero then, without being measured.
    """

    def __len__(self) -> int:
        return int(self.run.shape[0])

    @property
    def used(self) -> NDArray[np.bool_]:
        """(n,) True for the states that are neither set aside nor a reference."""
        keep = np.ones(len(self), dtype=np.bool_)
        if self.set_aside is not None:
            keep &= self.set_aside == ""
        if self.reference is not None:
            keep &= ~self.reference
        return np.asarray(keep, dtype=np.bool_)

    def reads(self, component: int) -> NDArray[np.bool_]:
        """Return (n,) True where something was read along one base axis (of rotations: wherever they were)."""
        if self.along is None or component > 2:
            return np.ones(len(self), dtype=np.bool_)
        return np.asarray(np.abs(self.along[:, component]) > 1e-3, dtype=np.bool_)

    @property
    def has_rotation(self) -> bool:
        """True where rotations were measured (six columns, not all NaN)."""
        return self.measured.shape[1] == 6 and bool(np.isfinite(self.measured[:, 3:]).any())

    @property
    def best_prediction(self) -> Floats:
        """The prediction for held-out poses where there is one, else the fit's."""
        return self.predicted if self.predicted_heldout is None else self.predicted_heldout

    @property
    def residual(self) -> Floats:
        """(n, 3) or (n, 6): measured minus `best_prediction`, m, rad."""
        return np.asarray(self.measured - self.best_prediction, dtype=np.float64)


@dataclass(frozen=True)
class ResidualCovariate:
    """Something a residual might follow: a joint torque, time, a temperature."""

    name: str
    """What it is, e.g. "torque on joint 4"."""
    unit: str
    """e.g. "N·m"."""
    values: Floats
    """(n,) one per load state, in that unit (printed as it is)."""


@dataclass(frozen=True)
class EffectPicture:
    """What an effect does on a simple example: one curve without it, one with it."""

    effect: str
    """Its name."""
    x_label: str
    """Label of the abscissa, with its unit."""
    y_label: str
    """Label of the ordinate, with its unit."""
    x: Floats
    """(n,) in the order in which the states were reached."""
    without: Floats
    """(n,) the curve without the effect, in the unit of ``y_label``."""
    with_effect: Floats
    """(n,) the curve with the effect, in the same unit."""
    unloading: Booleans
    """(n,) True where the load was going back; all False where it makes no difference."""
    caption: str
    """What the picture shows, and the example."""
    back: str = "unloading"
    """What the way back is called in the legend."""


@dataclass(frozen=True)
class EvidenceFigure:
    """The residual in held-out poses against what drives an effect, without and with it (n load states)."""

    evidence: EffectEvidenceSummary
    """Which effect, what the residual is drawn against, and the errors."""
    value: Floats
    """(n,) the covariate, in its unit."""
    before: Floats
    """(n,) m or rad, residual without the effect; NaN where nothing can be read."""
    after: Floats
    """(n,) m or rad, residual with the effect; NaN where nothing can be read."""
    branch: Strings
    """(n,) "loading", "unloading" or ""."""
    run: Strings
    """(n,) the runs' names; states of a run in the order in which they were reached."""
    path_run: str = ""
    """The run whose path is drawn, for effects with a memory; "" for others."""
    summary: str = ""
    """What the effect is, as the catalogue has it."""
    fingerprint: str = ""
    """How it shows in data, as the catalogue has it."""
    check: str = ""
    """How to check it on the machine, as the catalogue has it."""
    seen: str = ""
    """What was observed, with numbers; "" where no diagnosis has found it."""
    alternatives: tuple[EffectAt, ...] = ()
    """Look-alikes."""
    parameters: tuple[IdentifiedParameter, ...] = ()
    """Of the effect, as fitted."""
    picture: EffectPicture | None = None
    """What such an effect does, on a simple example; None where it cannot be drawn."""

    @property
    def can_be_drawn(self) -> bool:
        """Whether any state shows it."""
        return bool((np.isfinite(self.before) & np.isfinite(self.after) & np.isfinite(self.value)).any())

    @property
    def missing(self) -> bool:
        """True where the model lacks the effect, False where it holds it."""
        return self.evidence.status == "missing"

    @property
    def of_motors(self) -> bool:
        """Whether only angles of clamped motors were read."""
        return self.evidence.component == "motor_angle"


@dataclass(frozen=True)
class FitChange:
    """What a change of the model did to the identified values, on the same load states."""

    before: str
    """The earlier fit's number in the history."""
    after: str
    """The later fit's number."""
    change: str
    """What the model gained and lost, in words."""
    values: tuple[BeforeAfter, ...]
    """Every parameter of both models."""
    own: bool
    """Whether both fits are the user's own."""


@dataclass(frozen=True)
class PlaceShare:
    """How much of the target's deflection an effect at a place makes."""

    label: str
    """The place as it is printed, e.g. "joint 2"."""
    mark: str
    """The same in a picture, e.g. "2"."""
    share: float
    """Of the squares of the predicted deflection; all shares add up to 1."""
    joint: int | None
    """The joint, or the joint that moves the link, from 1; None for the set-up and couplings."""
    beyond_joint: bool = False
    """True for a link: it lies between this joint and the next."""


@dataclass(frozen=True)
class PoseStiffness:
    """The target's stiffness in one pose, along and about each base axis."""

    joints: Floats
    """(L,) rad, logged angles."""
    target: str
    """The frame that is loaded and gives."""
    compliance: Floats
    """(6,) m/N, then rad/(N·m): along each axis under a load along it alone."""
    std: Floats
    """(6,) standard uncertainties."""
    held: Floats | None
    """(6,) N/m, then N·m/rad: along each axis with the other directions held; None where a direction gives nothing."""


@dataclass(frozen=True)
class ReportContent:
    """All that a report shows."""

    provenance: ReportProvenance
    """Title page."""
    runs: tuple[ReportRun, ...]
    """The runs, in the manifest's order."""
    joint_names: tuple[str, ...]
    """Names of the logged joints (L)."""
    prismatic_joints: frozenset[int] = frozenset()
    """Those, from 1, that move along their axis: their positions are in m."""
    states: ReportStates | None = None
    """The load states; None where there are none (then all curves are left out)."""
    identify: IdentifyResult | None = None
    """The present fit; None where nothing is fitted."""
    validate: ValidateResult | None = None
    """Its validation; None where there is none."""
    history: HistoryResult | None = None
    """Every fit of the campaign; None where that is not known."""
    place_shares: tuple[PlaceShare, ...] = ()
    """What the places of the model contribute to the deflection, largest first; empty where none is predicted."""
    fit_changes: tuple[FitChange, ...] = ()
    """Fits of the history that follow each other with another model of the same load states, oldest first; where there
    are several, what all of them together changed comes before them."""
    ingest: IngestResult | None = None
    """How the load states came about; None where that is not known."""
    instruments: tuple[ReportInstrument, ...] = ()
    """The sensors."""
    set_aside: tuple[SetAsideRows, ...] = ()
    """What was not used and why."""
    covariates: tuple[ResidualCovariate, ...] = ()
    """What residuals are to be plotted against, most informative first."""
    load_paths: tuple[LoadPath, ...] = ()
    """Predicted paths of loads."""
    diagnose: DiagnoseResult | None = None
    """The result of `diagnose` for the present fit; None where there is none."""
    not_diagnosed: str = "not diagnosed: run stiffcal diagnose"
    """Why there is none, in words."""
    earlier_diagnoses: tuple[EarlierDiagnosis, ...] = ()
    """The diagnoses that led to the present model, oldest first."""
    evidence: tuple[EvidenceFigure, ...] = ()
    """The evidence for each effect that is missing, or in the model beyond the joints' compliances."""
    pages: tuple[Page, ...] = ()
    """What the kinds of experiment show."""
    main_tables: tuple[Table, ...] = ()
    """The leading table of each kind of experiment, for the first page."""
    joint_pictures: tuple[JointPicture, ...] = ()
    """Joints between tracked bodies, each by itself; none with one tracked body."""
    link_pictures: tuple[LinkPicture, ...] = ()
    """Links with rods."""
    stiffness_poses: tuple[PoseStiffness, ...] = ()
    """Cartesian stiffness in the poses that the campaign asks for."""
    workspace: MapResult | None = None
    """The map of the workspace that the campaign asks for."""
    logo: bytes = b""
    """PNG for the first page; empty where the campaign names none."""
    statistics: tuple[PictureOfFit, ...] = ()
    """Whether the statistics of the fit hold."""
    settings: ReportSettings = field(default_factory=ReportSettings)
    """Optional sections that the campaign asks for."""
    with_and_without: WithAndWithout | None = None
    """The same poses with the controller correcting and without; None where nothing was measured so."""

    @property
    def held_out(self) -> str:
        """What validation left out of the fit, in words: "held-out poses", "held-out regions" of absolute places."""
        return held_out(None if self.validate is None else self.validate.scheme)

    @property
    def known_noise(self) -> Rms | None:
        """The noise of held-out errors; with missing effects in the model, as these swell the scatter of repeats."""
        if self.diagnose is not None and self.diagnose.missing and self.diagnose.noise is not None:
            return self.diagnose.noise
        return None if self.validate is None else self.validate.noise

    @property
    def parameters_on_pages(self) -> frozenset[str]:
        """The names of the parameters that pages of kinds of experiment show: others need not show them again."""
        return frozenset(name for page in self.pages for name in page.parameters)

    @property
    def absolute_alone(self) -> bool:
        """Whether all runs are absolute poses."""
        return bool(self.runs) and all(run.measures is StateMeasure.PLACE for run in self.runs)

    @property
    def readings_alone(self) -> tuple[Page, ...]:
        """The pages with something on them where the campaign contains no load states, else none."""
        return () if self.states is not None else tuple(page for page in self.pages if page.blocks)

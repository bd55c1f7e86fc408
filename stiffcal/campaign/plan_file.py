"""plan.toml, typed: what is possible when the next campaign is measured."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field

from stiffcal.campaign.robot.sizes import Degrees, PositiveLength
from stiffcal.campaign.toml.reach import check_own
from stiffcal.campaign.toml.toml_reading import read_toml, validate
from stiffcal.campaign.toml.typed import Counting, Interval, Name, NotNegative, Positive, TomlTable, Vector3, at_most

PLAN_FILE = "plan.toml"
MOST_RUNS, MOST_CANDIDATES = 1000, 20000


class PlannedLoad(TomlTable):
    """The load that can be applied.

    Attributes
    ----------
    force_N : the largest force, N; of clamped robots at the fixture. moment_Nm : there the largest moment.
    steps : of the largest force, in order; 1 is all of it, -1 all of it in the other sense. The unloaded state before
        and after is added. Absent: 0.5 and 1; where the model or a rival has play, a knee or a memory, levels of both
        senses, up and down, so that a crossing and a hysteresis show.
    cycles : how often the steps are repeated, for the noise.
    directions : base axes, one per run; absent: along and against each axis.
    dead_weights_kg : masses hung on instead of a force, in order of the steps; the direction is gravity's.
    point : the frame where the load acts; absent: where campaign.toml has it.
    """

    force_N: Positive | None = None
    moment_Nm: Positive | None = None
    steps: Annotated[
        tuple[Annotated[float, Field(ge=-1, le=1)], ...], Field(strict=False), at_most(50, "name fewer steps")
    ] = ()
    cycles: Annotated[Counting, Field(le=20)] = 1
    directions: Annotated[tuple[Vector3, ...], Field(strict=False), at_most(100, "name fewer directions")] = ()
    dead_weights_kg: Annotated[tuple[Positive, ...], Field(strict=False), at_most(50, "name fewer masses")] = ()
    point: Name | None = None

    look_alikes: ClassVar[dict[str, str]] = {
        "force": "force_N", "max_force_N": "force_N", "masses_kg": "dead_weights_kg", "frame": "point",
    }  # fmt: skip


class PlannedTracker(TomlTable):
    """Where the tracker stands, and what it can measure.

    Attributes
    ----------
    position_m : base axes; absent: the origin of `[frames.tracker]` in campaign.toml. Links and keep-out boxes hide
        what is behind them.
    axis : base axes, the middle of its field of view; absent: any direction.
    cone_deg : half the opening angle of its field of view about `axis`.
    reflector_axis : outward from the reflector, in the measured frame; absent: it can be measured from all sides.
    acceptance_deg : the largest angle between the beam and `reflector_axis`.
    """

    position_m: Vector3 | None = None
    axis: Vector3 | None = None
    cone_deg: Annotated[Degrees, Field(gt=0, le=180)] = 180.0
    reflector_axis: Vector3 | None = None
    acceptance_deg: Annotated[Degrees, Field(gt=0, le=180)] = 30.0

    look_alikes: ClassVar[dict[str, str]] = {"xyz_m": "position_m", "cone": "cone_deg", "acceptance": "acceptance_deg"}


class Fixture(TomlTable):
    """A fixture that can clamp the flange.

    Attributes
    ----------
    joints_deg : the logged angles with which the flange is clamped there.
    """

    joints_deg: Annotated[tuple[float, ...], Field(strict=False)]


class KeepOutBox(TomlTable):
    """A box, edges along the base axes, that no link may enter."""

    min_m: Vector3
    max_m: Vector3


class PlannedRegion(TomlTable):
    """The work area: a box in which deflections (of absolute places: places) are to be predicted well.

    Attributes
    ----------
    min_m, max_m : its corners, base axes; the first measured frame is inside.
    force_N : of the loads there, along and against each base axis; absent: the plan's own loads.
    """

    min_m: Vector3
    max_m: Vector3
    force_N: Positive | None = None

    look_alikes: ClassVar[dict[str, str]] = {"force": "force_N"}


class PlannedNoise(TomlTable):
    """Standard uncertainty of one load state, where neither campaign.toml nor a fit has it.

    Attributes
    ----------
    translation_m, rotation_rad : of the measured pose, per axis. force_N, moment_Nm : of the wrench, per axis.
    motor_angle_rad : of the driven motor of a clamped robot, at the joint's side.
    """

    translation_m: Positive | None = None
    rotation_rad: Positive | None = None
    force_N: NotNegative | None = None
    moment_Nm: NotNegative | None = None
    motor_angle_rad: Positive | None = None


class PlanFile(TomlTable):
    """plan.toml.

    Attributes
    ----------
    experiment : what is measured: "load", "absolute" (each pose once, under the robot's own weight, and with each of
        `dead_weights_kg` as payload) or "clamped" (one joint driven at a time, the flange in a fixture). Absent: what
        the runs of campaign.toml are, else "load".
    robot_class : "light" (10 kg, harmonic drives), "medium" (60 kg) or "heavy" (200 kg): what joint compliances without
        a value are taken as. Absent: one typical value for all joints.
    parameters : full names of the parameters whose largest uncertainty counts for "stiffness"; absent: all but knees,
        bands and other nonlinear ones.
    runs : how many runs to plan (a pose with its load steps each); absent: what `minutes` allows, else 12, and of
        absolute places two thirds of the number of parameters where that is more.
    minutes : the time there is. warm_up_minutes : of these before the first run.
    minutes_per_run : to move and to attach the load. minutes_per_step : for each load step and unloaded state.
    candidates : random poses to choose from. seed : of their drawing.
    repeats : how often one pose (within 10° of each joint) with one load may be measured.
    limits_deg : of the logged angles, by joint name, tighter than robot.toml's. margin_deg : distance to every limit.
    fixtures : those that can clamp the flange; absent: one at any possible pose.
    region : the work area, for `--for region`.
    prior_range : where a nonlinear parameter (a knee, a band) may lie, by full name; absent: a third to three times the
        typical value where model.toml and the fit give none. The plan serves both ends and the value itself.
    keep_out : boxes that no link may enter. link_radius_m : of the capsules around the links.
    lowest_m : height in base axes that no link may go below.
    """

    schema_id: Literal["stiffcal/plan-input/1"] = Field("stiffcal/plan-input/1", alias="schema")
    experiment: Literal["load", "absolute", "clamped"] | None = None
    robot_class: Literal["light", "medium", "heavy"] | None = None
    parameters: Annotated[tuple[Name, ...], Field(strict=False), at_most(200, "name fewer, or none for all")] = ()
    runs: Annotated[Counting, Field(le=MOST_RUNS)] | None = None
    minutes: Positive | None = None
    warm_up_minutes: NotNegative = 0.0
    minutes_per_run: Positive = 4.0
    minutes_per_step: NotNegative = 1.0
    candidates: Annotated[Counting, Field(le=MOST_CANDIDATES)] = 200
    seed: Annotated[int, Field(ge=0)] = 0
    repeats: Counting = 1
    load: PlannedLoad = PlannedLoad()
    noise: PlannedNoise = PlannedNoise()
    tracker: PlannedTracker | None = None
    limits_deg: dict[str, Interval] = Field(default_factory=dict)
    prior_range: dict[str, Interval] = Field(default_factory=dict)
    fixtures: Annotated[tuple[Fixture, ...], Field(strict=False), at_most(200, "name fewer fixtures")] = ()
    region: PlannedRegion | None = None
    margin_deg: NotNegative = 5.0
    keep_out: Annotated[tuple[KeepOutBox, ...], Field(strict=False), at_most(200, "merge boxes")] = ()
    link_radius_m: PositiveLength = 0.15
    lowest_m: float | None = None

    look_alikes: ClassVar[dict[str, str]] = {
        "poses": "runs", "budget": "minutes", "boxes": "keep_out", "limits": "limits_deg", "radius_m": "link_radius_m",
    }  # fmt: skip


def load_plan(folder: Path) -> PlanFile:
    """Read plan.toml of a campaign folder; the defaults where there is none.

    Raises
    ------
    InputError : it cannot be read, or a key is wrong.
    """
    path = Path(folder) / PLAN_FILE
    if not path.exists():
        return PlanFile.model_validate({})
    check_own(Path(folder), PLAN_FILE)
    return check_plan(read_toml(path, PLAN_FILE))


def check_plan(document: dict[str, Any]) -> PlanFile:
    """Return a document of plan.toml as its type; raises `InputError` with one fault per wrong key."""
    return validate(document, PLAN_FILE, PlanFile)

"""A joint that is turned, its torque read: rows of a kind of its own, in which effects are searched for."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import product

import numpy as np
import pyarrow as pa

from stiffcal.arrays import Floats, Integers
from stiffcal.campaign.loading import Campaign
from stiffcal.campaign.manifest.manifest import Run
from stiffcal.estimation.groups import GroupNoise
from stiffcal.estimation.parameters import reported_parameters
from stiffcal.estimation.rows import Rows
from stiffcal.estimation.step import solve_step
from stiffcal.estimation.unknowns import ParameterColumn, Unknowns, free_columns, with_estimates
from stiffcal.identification.answers.document import identified_parameter, model_summary
from stiffcal.identification.fitting.regressors import Regressor
from stiffcal.identification.readings.search_subject import SearchSubject
from stiffcal.kinds import ExperimentKind
from stiffcal.kinds.measured import MeasuredRuns
from stiffcal.kinds.reduction import RunsReduction
from stiffcal.kinds.results import ExperimentFit, ExperimentValidation, IdentifiedModel
from stiffcal.kinds.row_search import RowCourse, RowCovariate, RowFit, RowNoise, RowProblem, UsualMotion
from stiffcal.measurements.columns import table_of, values_of
from stiffcal.mechanics.chain import Chain
from stiffcal.model.assembled.composite import CompliantRobot
from stiffcal.model.catalogue.campaign_effects import moving_effects
from stiffcal.model.drive_motion import DriveMotion
from stiffcal.model.effect import Effect, Place
from stiffcal.model.motion import Motion, as_motion
from stiffcal.presentation.values import Overview, Page, Sentence
from stiffcal.reduction.logs.blocks import Blocks
from stiffcal.reduction.states.ingested_runs import IngestedRun
from stiffcal.store.provenance import IngestSettings
from stiffcal.uncertainty import NORMAL_95

TURNING = "turning"
COLUMNS = ("turn", "time_s", "angle_rad", "velocity_radps", "torque_Nm")
# of one reading, N·m: a torque sensor's data sheet says it
SIGMA = 0.1


@dataclass(frozen=True, slots=True, kw_only=True)
class TurningSection:
    """What was turned."""

    turns: int


class TurningReduction(RunsReduction):
    """The readings of each turn."""

    def __init__(self, campaign: Campaign) -> None:
        super().__init__(campaign)
        self._turns: list[Floats] = []

    def add(self, run: Run, logs: Mapping[str, Blocks]) -> None:
        """Keep time, angle, velocity and torque of the joint."""
        (blocks,) = logs.values()
        signals = [blocks.mean[name][:, 0] for name in ("joints", "joints.velocity", "joints.torque")]
        self._turns.append(np.stack([np.full(len(blocks), len(self._turns)), blocks.time, *signals]))
        self.entries.append(IngestedRun(id=run.id, clock_ahead_s={}, n_states=0, n_readings=len(blocks), dropped=[]))

    def tables(self, settings: IngestSettings) -> dict[str, pa.Table]:
        """Return a row for each reading."""
        if not self._turns:
            return {}
        return {TURNING: table_of(dict(zip(COLUMNS, np.concatenate(self._turns, axis=1), strict=True)))}


@dataclass(frozen=True)
class TurningProblem(RowProblem):
    """The rows of joint 1."""

    rows: Floats
    """(5, k) in the order of `COLUMNS`."""
    model: CompliantRobot
    measure = "torque"
    unit = "N·m"
    subject = SearchSubject(TURNING, "Torque of a turned joint", "in turns that were left out")
    folds_in_words = "turns"
    joints = (1,)

    @property
    def robot(self) -> CompliantRobot:
        """The model's effects of moving joints."""
        return self.model

    @cached_property
    def index(self) -> Integers:  # type: ignore[override]
        """(k,) all rows."""
        return np.arange(self.rows.shape[1])

    @cached_property
    def motion(self) -> DriveMotion:
        """The motion in each row."""
        _, time, angle, velocity, _ = self.rows
        none = np.full(len(time), np.nan)
        return DriveMotion(velocity, angle, np.zeros(len(time)), none, time, none)

    def shapes(self, effect: Effect, place: Place) -> list[dict[str, float]]:
        """Return the values of a shape that are tried."""
        grid = as_motion(effect).motion_grid(place, self.chain, self.motion)
        return [dict(zip(grid, map(float, values), strict=True)) for values in product(*grid.values())]

    def regressor(self, effect: Effect, place: Place, shape: Mapping[str, float]) -> Regressor:
        """Return the torque per unit of each amplitude."""
        made = as_motion(effect).motion_columns(place, self.chain, self.motion, shape)
        k = self.rows.shape[1]
        columns = np.stack([column[None] for column in made.values()]) if made else np.zeros((0, 1, k))
        return Regressor(effect, place, dict(shape), tuple(made), columns, np.zeros((1, k)))

    @property
    def chain(self) -> Chain:
        """The robot."""
        return self.model.chain

    def fit(self, robot: CompliantRobot) -> RowFit:
        """Fit the amplitudes of a model; a shape that has no value is the one of its grid that leaves least."""
        for number, placed in enumerate(robot.placed):
            if not placed.shape().keys() <= placed.values.keys():
                before, after = robot.placed[:number], robot.placed[number + 1 :]
                shapes = self.shapes(placed.effect, placed.place)
                tried = [replace(robot, placed=(*before, replace(placed, values=shape), *after)) for shape in shapes]
                return min(map(self.fit, tried), key=lambda fit: float(np.sum(fit.rows.residual**2)))
        held = frozenset(placed.parameter_name(symbol) for placed in robot.placed for symbol in placed.shape())
        columns = free_columns(robot, held)
        rows = self._about(robot, columns)
        values, _ = solve_step(rows.reduced(), rows.unknowns, rows.values)
        rows = replace(rows, values=values, predicted=np.einsum("p,pmk->mk", values, rows.derivative))
        fitted = with_estimates(robot, columns, values)
        spread = np.sqrt(np.diagonal(rows.reduced().covariance(np.ones(len(values), dtype=np.bool_))))
        std = dict(zip(rows.unknowns.names, spread.tolist(), strict=True))
        parameters = tuple(reported_parameters(fitted, std, NORMAL_95, held))
        k, turn = self.rows.shape[1], self.rows[0].astype(np.int64)
        return RowFit(
            robot=fitted, rows=rows, noise=RowNoise(k, "manifest"), sigma=np.full(k, SIGMA), constant=np.full(k, -1),
            fold=turn, run=turn, maker=self, parameters=parameters,
            identified=tuple(map(identified_parameter, parameters)),
        )  # fmt: skip

    def _about(self, robot: CompliantRobot, columns: list[ParameterColumn]) -> Rows:
        """Return the rows about amplitudes of nothing."""
        made = [self.regressor(placed.effect, placed.place, placed.shape()) for placed in robot.placed]
        slopes = [made[one.placed].columns[made[one.placed].symbols.index(one.symbol)] for one in columns]
        p, measured = len(columns), self.rows[4][None]
        noise = GroupNoise.independent(np.full_like(measured, SIGMA), self.rows[0].astype(np.int64))
        return Rows(
            Unknowns.of(robot, columns), np.zeros(p), np.array(slopes).reshape(p, *measured.shape),
            np.zeros_like(measured), measured, np.ones(measured.shape, dtype=np.bool_), noise, np.zeros((0, p + 1)),
        )  # fmt: skip

    def places(self, effect: Effect) -> list[Place]:
        """Return joint 1 for effects of moving joints."""
        return [Place("joints", (1,))] if isinstance(effect, Motion) else []

    def lacking(self, effect: Effect, place: Place) -> str | None:
        """Return what the law says."""
        return as_motion(effect).lacking_motion(self.chain, self.motion)

    def covariates(self) -> list[RowCovariate]:
        """Return the angle."""
        return [RowCovariate("position", self.rows[2], "the residual depends on the joint angle")]

    def course(self) -> RowCourse:
        """Return the turns in their order."""
        turn, time, _, velocity, _ = self.rows
        return RowCourse(np.ones(len(turn), dtype=np.int64), time, np.sign(velocity), turn.astype(np.int64))

    def group_in_words(self, group: int) -> str:
        """Return a turn's number."""
        return f"turn {group + 1}"

    def usual(self, joint: int) -> UsualMotion:
        """Return how it turns."""
        return UsualMotion(float(np.sqrt(np.mean(self.rows[4] ** 2))), float(np.sqrt(np.mean(self.rows[3] ** 2))))


class TurningKind(ExperimentKind):
    """Torque of a joint that is turned."""

    def reduction(self, campaign: Campaign) -> RunsReduction:
        """Collect the turns."""
        return TurningReduction(campaign)

    def problems(self, data: MeasuredRuns) -> tuple[RowProblem, ...]:
        """Return the rows of the joint."""
        rows = data.read(TURNING, lambda table: np.stack([values_of(table.column(name)) for name in COLUMNS]))
        robot = CompliantRobot(data.campaign.chain, moving_effects(data.campaign))
        return () if rows is None else (TurningProblem(rows, robot),)

    def section_type(self) -> type[object]:
        """Return the type of the section in ``identify``."""
        return TurningSection

    def fit(self, data: MeasuredRuns) -> ExperimentFit | None:
        """Fit the model's effects."""
        for problem in self.problems(data):
            fit = problem.fit(problem.robot)
            return ExperimentFit(
                name=TURNING, section=TurningSection(turns=len(np.unique(fit.run))), parameters=list(fit.identified),
                effects=model_summary(fit.robot).effects, rms={"torque": float(np.sqrt(np.mean(fit.rows.residual**2)))},
                noise={"torque": SIGMA}, noise_source="manifest", n_runs=len(np.unique(fit.run)),
                n_readings=fit.rows.residual.size, free=list(fit.names),
                covariance=np.diag([(one.std or 0.0) ** 2 for one in fit.parameters if one.name in fit.names]).tolist(),
            )  # fmt: skip
        return None

    def validate(self, data: MeasuredRuns) -> ExperimentValidation | None:
        """Say what the fit leaves: two parameters of hundreds of readings."""
        for problem in self.problems(data):
            left = problem.fit(problem.robot).rows.residual[0]
            rms: dict[str, float | None] = {"torque": float(np.sqrt(np.mean(left**2)))}
            return ExperimentValidation(
                name=TURNING, scheme="none", rms=rms, max={"torque": float(np.abs(left).max())},
                noise={"torque": SIGMA}, relative={}, zero_model={}, n_readings=len(left),
            )  # fmt: skip
        return None

    def overview(self, identified: IdentifiedModel) -> Overview | None:
        """Return one sentence."""
        section = identified.section(TURNING)
        if not isinstance(section, TurningSection):
            return None
        return Overview((Sentence((f"the joint was turned {section.turns} times",), "turns"),))

    def page(self, data: MeasuredRuns, identified: IdentifiedModel) -> Page | None:
        """Return the same."""
        overview = self.overview(identified)
        return None if overview is None else Page("The turned joint", overview.blocks, subject="turned joint")


KIND = TurningKind(TURNING, tables=(TURNING,), measures=None)

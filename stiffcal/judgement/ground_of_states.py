"""A robot at rest under its loads, about which members are compared."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from stiffcal.arrays import Floats, Integers
from stiffcal.diagnosis.scans.drift import Drift, drift_of_states
from stiffcal.diagnosis.scans.slips import best_slip
from stiffcal.identification.fitting.regressors import Linearised
from stiffcal.identification.noise.projection import Projection
from stiffcal.identification.readings.row_layout import MEASURES, MOTOR, TRANSLATION
from stiffcal.judgement.discrepancy import Discrepancy, OffRun, off_by_run
from stiffcal.judgement.ground import CheckKind, Ground
from stiffcal.judgement.like_states import sweeps_of, variance_of
from stiffcal.judgement.numbers import LOADED
from stiffcal.mistakes.states.mistake import LeftOfStates

_OF_MEASURE = {
    "translation": CheckKind.TRANSLATION, "rotation": CheckKind.ROTATION, "length": CheckKind.LENGTH,
}  # fmt: skip


@dataclass(frozen=True)
class GroundOfStates(Ground):
    """A robot at rest in load states."""

    state: Linearised
    """The robot."""
    space: Projection
    """Weights and runs."""
    of_wrench: Floats = field(kw_only=True)
    """(6, n) standard uncertainties of the wrenches, N and N·m."""

    @property
    def checked(self) -> Mapping[CheckKind, Integers]:
        """Positions of components by measure; not of clamped motors: like states leave out what cycles repeat."""
        kind = self.space.data.kind
        return {check: np.flatnonzero(np.isin(kind, MEASURES[measure])) for measure, check in _OF_MEASURE.items()}

    def uneven_noise(self) -> Floats:
        """Return (n,) by what like states of sweeps scatter beyond the noise that most of them have; 1 elsewhere."""
        found, variance = np.ones(self.space.data.n_states), variance_of(self.space.whitening)
        for sweep in sweeps_of(self.space.data):
            own = sweep.row, sweep.states
            found[sweep.states] = max(float(np.mean(sweep.scatter(self.residual[own], variance[own]))), 1.0)
        return found

    @property
    def drift(self) -> Drift:
        """What the model leaves in the course of runs."""
        return drift_of_states(self.space.data, self.white.reshape(self.space.data.measured.shape), self.noise.dof)

    @property
    def stated(self) -> Integers:
        """Positions of translations."""
        return self.space.data.rows_of(TRANSLATION)

    @property
    def log_weights(self) -> float:
        """As of `Ground.log_weights`: the wrench's noise is carried through the slope of the model.

        It stands for wrenches of which any is as probable as another before they are read. Of states whose wrench is
        none within its noise it is none, exactly: the robot is unloaded. A clamped motor is driven in even steps of its
        angle: torques are as dense there as the law is steep, which makes up for it.
        """
        lower, data = self.space.whitening.lower, self.space.data
        if lower is None:
            return 0.0
        over = np.max(np.abs(data.wrench) / np.maximum(self.of_wrench, 1e-300), axis=0)
        clamped = data.measured_mask[data.kind == MOTOR].any(axis=0)
        loaded = data.measured_mask & (over > LOADED) & ~clamped
        return float(np.sum(np.log(np.einsum("aan->an", lower)[loaded])))

    def runs_off(self) -> Iterator[OffRun]:
        """Give how each run alone may be off."""
        of_loads, of_time = self.of_loads, self.of_time
        if self.shared.lasting is not None:
            of_loads, of_time = Discrepancy.of_loads(self.space), Discrepancy.of_time(self.space)
        return off_by_run(of_loads, of_time, self.shared.columns[~self.shared.prior[:, :-1].any(axis=0)])

    def steps(self) -> tuple[int, float | None]:
        """Return the number of states at which a target may slip, and the state where a slip explains most."""
        numbers = self.space.data.order.number
        first = best_slip(self.space, self.residual) if len(numbers) else None
        return len(numbers), None if first is None else float(numbers[first])

    @cached_property
    def left(self) -> LeftOfStates:
        """What the model leaves, on which mistakes are tried."""
        data = self.space.data
        return LeftOfStates(
            residual=self.residual,
            scale=self.space.whitening.scale,
            space=self.space,
            run=data.run,
            absolute=data.absolute,
            wrench=data.wrench,
            response=self.state.tangents.reading_rows(),
            swept=frozenset(sweep.run for sweep in sweeps_of(data)),
            has_constants=data.free_offset,
            step=best_slip(self.space, self.residual) if data.free_offset else None,
            n_runs=len(self.of_loads.runs),
        )

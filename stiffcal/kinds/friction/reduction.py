"""Logs of friction runs collected: passes of one joint at one speed go together, wherever they were logged."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.campaign.loading import Campaign
from stiffcal.campaign.manifest.manifest import Run
from stiffcal.campaign.robot.robot_checks import weight_faults
from stiffcal.errors import raise_faults
from stiffcal.kinds.friction.fitting.identifiability import motion_lack
from stiffcal.kinds.friction.logs.friction_run import FrictionRun
from stiffcal.kinds.friction.logs.readings import motion_table, steady_table
from stiffcal.kinds.friction.logs.runs import FrictionReduction, friction_run, reduce_friction
from stiffcal.kinds.friction.logs.samples import samples_table
from stiffcal.kinds.reduction import RunsReduction
from stiffcal.reduction.logs.blocks import Blocks
from stiffcal.reduction.states.ingested_runs import IngestedRun, UnusedData, sum_up_dropped
from stiffcal.store.provenance import IngestSettings

if TYPE_CHECKING:
    import pyarrow as pa

FRICTION, FREE_MOTION, FRICTION_SAMPLES = "friction", "free_motion", "friction_samples"


class FrictionRunsReduction(RunsReduction):
    """The logs of friction runs, and what they hold once all are read."""

    reads_first_lines = False

    def __init__(self, campaign: Campaign) -> None:
        super().__init__(campaign)
        self._runs: list[FrictionRun] = []
        self._friction: FrictionReduction | None = None

    def add(self, run: Run, logs: Mapping[str, Blocks]) -> None:
        """Bring the logs of a run to one clock."""
        self._runs.append(friction_run(run, logs))

    def finish(self) -> None:
        """Find the passes at constant velocity, and the samples of other motion."""
        if not self._runs:
            return
        self._friction = reduce_friction(self._runs, self.campaign.chain)
        robot, file = self.campaign.robot, self.campaign.manifest.robot
        if self._friction.motion is not None:
            raise_faults(weight_faults(robot, file, self._friction.motion.runs[0].name))
        if self._friction.steady is not None:
            raise_faults(weight_faults(robot, file, self._friction.steady.runs[0].name, steady=True))
        self.warnings += self._friction.warnings
        self.entries += [_entry(run, self._friction) for run in self._runs]

    def tables(self, settings: IngestSettings) -> dict[str, pa.Table]:
        """Return passes, samples within them, and samples of other motion."""
        tables: dict[str, pa.Table] = {}
        names = self.campaign.chain.joint_names
        if self._friction is not None and self._friction.steady is not None:
            tables[FRICTION] = steady_table(self._friction.steady, names)
        if self._friction is not None and self._friction.samples is not None:
            tables[FRICTION_SAMPLES] = samples_table(self._friction.samples, names)
        if self._friction is not None and self._friction.motion is not None:
            tables[FREE_MOTION] = motion_table(self._friction.motion, names)
        return tables

    def check(self) -> tuple[list[str], list[str]]:
        """Name every joint whose friction the model asks for and no run shows."""
        from stiffcal.model.catalogue.campaign_effects import moving_effects

        if self._friction is None:
            return [], []
        steady, motion = self._friction.steady, self._friction.motion
        measured = set() if steady is None else set(steady.joint[steady.used].tolist())
        if motion is not None:
            measured |= {k + 1 for k, one_way in enumerate(motion.one_way.T) if one_way.any()}
        names = self.campaign.chain.joint_names
        requested = [effect.place.joints[0] for effect in moving_effects(self.campaign)]
        missing = []
        for joint in dict.fromkeys(requested):
            if joint not in measured:
                missing.append(f"joint {names[joint - 1]}: no run measures its friction: move it in both directions")
            elif (lack := motion_lack(_velocities(self._friction, joint))) is not None:
                missing.append(f"joint {names[joint - 1]}: {lack.sentence}")
        return missing, []


def _velocities(friction: FrictionReduction, joint: int) -> Floats:
    """Return (n,) rad/s of the readings of a joint that are used."""
    velocities = []
    if friction.steady is not None:
        velocities.append(friction.steady.velocity[(friction.steady.joint == joint) & friction.steady.used])
    if friction.motion is not None:
        moving = friction.motion.one_way[:, joint - 1]
        velocities.append(friction.motion.drive_velocity[moving, joint - 1])
    return np.concatenate(velocities) if velocities else np.zeros(0)


def _entry(run: FrictionRun, friction: FrictionReduction) -> IngestedRun:
    """Return the answer of `ingest` for a run: readings that are used, strokes that gave none."""
    name, steady, motion = run.info.name, friction.steady, friction.motion
    readings, dropped = 0, sum_up_dropped(friction.dropped.get(name, ()))
    if steady is not None:
        in_run = np.array([steady.runs[k].name == name for k in steady.run], dtype=np.bool_)
        readings += int((in_run & steady.used).sum())
        codes = steady.set_aside_code
        for code in np.unique(codes[in_run & ~steady.used]):
            of_code = in_run & (codes == code)
            why = str(steady.set_aside[of_code][0])
            dropped.append(UnusedData(why=why, code=str(code), pieces=int(of_code.sum())))
    if motion is not None:
        readings += int(np.sum([motion.runs[k].name == name for k in motion.run]))
    return IngestedRun(id=name, clock_ahead_s=dict(run.clocks), n_states=0, n_readings=readings, dropped=dropped)

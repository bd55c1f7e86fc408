"""Logs of clamped runs brought together: readings for the descriptions of a joint, load states for the fit."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.campaign.loading import Campaign
from stiffcal.campaign.manifest.manifest import Run
from stiffcal.documents import document_of
from stiffcal.kinds.clamped.held.faults import run_quality
from stiffcal.kinds.clamped.held.holding import held_wrench
from stiffcal.kinds.clamped.logs.readings import CLAMPED, ClampedReadings, readings_table, stacked_readings
from stiffcal.kinds.clamped.logs.sweeps import clamped_readings, moved_joint
from stiffcal.kinds.clamped.states.states import clamped_states
from stiffcal.kinds.reduction import RunsReduction
from stiffcal.reduction.logs.blocks import Blocks
from stiffcal.reduction.states.ingested_runs import IngestedRun
from stiffcal.reduction.states.raw_states import RawStates
from stiffcal.store.provenance import IngestSettings

if TYPE_CHECKING:
    import pyarrow as pa


def _temperature(logs: Mapping[str, Blocks], time: Floats) -> Floats | None:
    """Return (n, T) the temperatures of the first log that holds some, at times of the log of motor angles."""
    for blocks in logs.values():
        values = blocks.mean.get("temperature")
        if values is not None:
            return np.stack([np.interp(time, blocks.time, column) for column in values.T], axis=1)
    return None


class ClampedReduction(RunsReduction):
    """The readings of clamped runs."""

    def __init__(self, campaign: Campaign) -> None:
        super().__init__(campaign)
        self._readings: list[ClampedReadings] = []

    def add(self, run: Run, logs: Mapping[str, Blocks]) -> RawStates | None:
        """Bring the logs of a run to one clock."""
        readings, clocks = clamped_readings(run, logs)
        joint = moved_joint(run.id, readings.joints, run.moved_joint, self.campaign.chain.joint_names)
        self._readings.append(readings)
        self.entries.append(
            IngestedRun(id=run.id, clock_ahead_s=clocks, n_states=0, n_readings=len(readings), dropped=[])
        )
        wrench = held_wrench(self.campaign, readings, run, joint)
        if wrench is None:
            return None
        from stiffcal.kinds.clamped.answers.parts import chain_of_run

        quality = run_quality(readings, chain_of_run(self.campaign, readings, run))
        return clamped_states(readings, joint, wrench, _temperature(logs, readings.time), quality)

    def tables(self, settings: IngestSettings) -> dict[str, pa.Table]:
        """Return the readings of all runs."""
        if not self._readings:
            return {}
        return {
            CLAMPED: readings_table(
                stacked_readings(self._readings), self.campaign.chain.joint_names, document_of(settings)
            )
        }

    def check(self) -> tuple[list[str], list[str]]:
        """Name the runs without a whole sweep, those whose torque is limited, and those that contradict themselves."""
        from stiffcal.kinds.clamped.answers.parts import check_clamped_runs

        return check_clamped_runs(self.campaign, self._readings)

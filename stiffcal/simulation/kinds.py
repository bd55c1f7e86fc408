"""What simulates the runs of one kind of experiment, where these are no load cycles.

Why asked for by name: the kinds of experiment lie above this package, and are found by walking their folder.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Generic, TypeVar, cast

from stiffcal.campaign.found.experiment_kinds import experiment_kind
from stiffcal.campaign.toml.typed import TomlTable
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode

if TYPE_CHECKING:
    from numpy.random import Generator

    from stiffcal.measurements.load_states import Attachment
    from stiffcal.mechanics.chain import Chain
    from stiffcal.model.assembled.composite import CompliantRobot
    from stiffcal.simulation.played.true_motion import PlannedRun, ToolWeight, TrueRun
    from stiffcal.simulation.settings import Loads, SimulatedRun

Motion = TypeVar("Motion", bound=TomlTable)


@dataclass(frozen=True)
class RunSetup:
    """A run that is to be planned."""

    run: SimulatedRun
    moved_joint: int | None
    """As in the manifest, from 1."""
    loads: Loads
    """The load cycles that the run would have."""
    frames: Mapping[str, Attachment]
    """Where they really are."""
    start_s: float
    """s, on the campaign's clock."""
    chain: Chain
    """As the robot file describes it."""
    rng: Generator
    """For what the run draws."""

    def driven_joint(self) -> int:
        """Return the driven joint, from 1.

        Raises
        ------
        InputError : the manifest does not say.
        """
        if self.moved_joint is None:
            raise InputError.at(
                FaultCode.KEY_MISSING,
                "campaign.toml",
                f'runs "{self.run.id}"',
                "which joint is driven is not stated",
                "add moved_joint = 1, say",
            )
        return self.moved_joint


class RunSimulation(ABC, Generic[Motion]):
    """The runs of one kind, simulated; `Motion` is the kind's table in `simulate.toml`, under the kind's name."""

    settings: type[Motion]
    """That table; a run changes single keys of it."""

    @abstractmethod
    def extent(self, motion: Motion) -> tuple[float, float]:
        """Return the number of balances that a run takes, and its length in s, both at most."""

    def frames(self, motion: Motion) -> tuple[tuple[str, str], ...]:
        """Return (key, name) of each frame that the run needs; the key as messages name it."""
        return ()

    @abstractmethod
    def plan(self, motion: Motion, setup: RunSetup) -> PlannedRun:
        """Return the plan of a run; its program is a `MotionProgram`.

        Raises
        ------
        InputError : which joint is driven is not known.
        """

    @abstractmethod
    def true_run(
        self,
        robot: CompliantRobot,
        planned: PlannedRun,
        frames: Mapping[str, Attachment],
        tool: ToolWeight,
        motion: Motion,
    ) -> TrueRun:
        """Return the true motion of the robot in a planned run.

        Parameters
        ----------
        robot : chain and effects with values.
        planned : of `plan`.
        frames : the frames that instruments look at.
        tool : what is mounted on the flange.
        motion : of this run.

        Raises
        ------
        InputError : the robot finds no balance.
        """


def run_simulation(experiment: str) -> RunSimulation[TomlTable] | None:
    """Return the simulation of the runs of a kind of experiment; None where these are load cycles.

    Examples
    --------
    >>> run_simulation("load") is None, run_simulation("friction").settings.__name__
    (True, 'FrictionMotion')
    """
    kind = experiment_kind(experiment)
    return None if kind is None else cast("RunSimulation[TomlTable] | None", kind.simulation())

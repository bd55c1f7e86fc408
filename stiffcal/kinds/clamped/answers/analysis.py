"""The clamped robot (004): backlash, friction and torque-angle curve of each joint that was driven against the fixture.

Definitions (physics, section 7). *Play* is the length of the segment about the crossing whose slope stays below a
quarter of the outer slope, common to both branches: the law's slope, which both share. *Friction* is half the torque
between the branches at all angles. *Reversal error* is the raw width between the branches at zero torque, which
friction alone can cause. All are averaged over cycles; their resolution comes from the encoder's step, the noise and
the distance of readings.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from stiffcal.arrays import Floats
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.kinds.clamped.held.chain import ClampedChain, drive_deflection
from stiffcal.kinds.clamped.held.faults import ONE_WAY, why_no_sweep
from stiffcal.kinds.clamped.held.saturation import Saturation, find_saturation
from stiffcal.kinds.clamped.logs.readings import ClampedReadings
from stiffcal.kinds.clamped.logs.sweeps import Sweeps, cut_sweeps
from stiffcal.kinds.clamped.loops.branches import Branches, average_branches, reversal_error
from stiffcal.kinds.clamped.loops.torque_angle import PlaySegment, TorqueAngleLaw, play_segment
from stiffcal.kinds.clamped.loops.torque_angle_fit import SeriesFit, fit_series
from stiffcal.uncertainty import NORMAL_95
from stiffcal.wording import angle

N_BINS = 120
# Friction counts as found beyond so many standard uncertainties, and beyond this share of the largest torque.
FOUND = 4.0
LEAST_FRICTION = 0.005
# Where the whole motion is less than this times the play, hardly anything of the flanks is measured (004, Fig. 8).
LEAST_MOTION = 1.3
# Whole chain: passes over all joints until the drives' shares of each other's motion stand still.
# Passes over joints that look alike, at least; and at most, until no drive's give moves by more than this share of it.
PASSES, MOST_PASSES, SETTLED = 3, 20, 1e-3


@dataclass(frozen=True)
class ClampedRun:
    """One joint in one pose."""

    name: str
    """The run's id."""
    joint: int
    """The driven joint, from 1."""
    holdout: bool
    """True where the joint's result never uses this run."""
    chain: ClampedChain
    """The run in drive coordinates."""
    sweeps: Sweeps
    """Its half sweeps."""
    branches: Branches
    """Torque over angle, averaged over the half sweeps."""
    fit: SeriesFit
    """The law fitted to the branches."""
    segment: PlaySegment | None
    """The play as a segment of low slope; None without play."""
    cycle_spread: float
    """rad, standard deviation of the play between cycles; NaN with fewer than two."""
    motion: float
    """rad, span of the joint's angle."""
    encoder_step: float
    """rad, smallest step of the angle; 0 where none shows."""
    resolution: float
    """rad, what the play is known to at best: encoder step, noise on the flanks, and the distance of readings."""
    reversal: float | None
    """rad, raw width between the branches at zero torque; None where they do not come there."""
    saturation: Saturation | None
    """Where the torque ran into a limit; None where it did not."""
    others_share: float
    """Share of the motion that other drives take up."""
    left_out: str = ""
    """Why the joint's result does not use this run; "" where it does."""

    @property
    def play(self) -> float:
        """The play, rad; 0 where there is none."""
        return 0.0 if self.segment is None or not self.fit.play_found else self.segment.length

    @property
    def both_ways(self) -> bool:
        """True where the joint was driven both ways."""
        return bool(self.branches.up.any() and not self.branches.up.all())

    @property
    def friction_found(self) -> bool:
        """True where the branches stand apart by a torque that noise does not make."""
        friction = self.fit.law.friction
        largest = float(np.abs(self.branches.torque).max(initial=0.0))
        return self.both_ways and friction > max(FOUND * self.fit.std("friction"), LEAST_FRICTION * largest)


def analyse_runs(
    readings: Sequence[ClampedReadings], chains: Sequence[ClampedChain], limits: float | None = None
) -> list[ClampedRun]:
    """Analyse clamped runs, joints that look alike in a pose by turns until they agree.

    Parameters
    ----------
    readings, chains : one each per run.
    limits : N·m beyond which torques are known to be cut off, or None: found where they are.

    Raises
    ------
    InputError : the passes do not settle.
    """
    laws: dict[int, TorqueAngleLaw] = {}
    coupled = any(not chain.is_distinguishable for chain in chains)
    runs: list[ClampedRun] = []
    for number in range(1, MOST_PASSES + 1):
        before = laws
        runs = judged(
            [
                _analyse_run(run_readings, chain, laws) if chain.is_excited else _unusable_run(run_readings, chain)
                for run_readings, chain in zip(readings, chains, strict=True)
            ]
        )
        laws = {joint: widest(runs, joint).fit.law for joint in sorted({run.joint for run in runs if not run.left_out})}
        if not coupled or (number >= PASSES and _agree(before, laws)):
            return runs
    raise InputError.at(
        FaultCode.NO_CONVERGENCE,
        "campaign.toml", "runs", "the iteration over clamped joints that move the flange alike does not converge in "
        f"{MOST_PASSES} passes",
        "clamp the robot in a pose in which no other joint moves the flange like the driven one",
    )  # fmt: skip


def _agree(before: Mapping[int, TorqueAngleLaw], after: Mapping[int, TorqueAngleLaw]) -> bool:
    """Return True where the drives give alike under both passes' laws."""
    if before.keys() != after.keys():
        return False
    for joint, law in after.items():
        _, torque = law.grid()
        give = drive_deflection(law, torque)
        if np.abs(give - drive_deflection(before[joint], torque)).max() > SETTLED * np.ptp(give):
            return False
    return True


def widest(runs: Sequence[ClampedRun], joint: int) -> ClampedRun:
    """Return the run that moved a joint furthest beyond its play, among those that are used."""
    return max((run for run in runs if run.joint == joint and not run.left_out), key=lambda run: run.motion - run.play)


def _analyse_run(readings: ClampedReadings, chain: ClampedChain, laws: Mapping[int, TorqueAngleLaw]) -> ClampedRun:
    angle, torque = chain.angle(laws), chain.torque[:, chain.joint - 1]
    sweeps = cut_sweeps(angle, torque)
    saturation = find_saturation(readings, angle, torque, chain)
    used = np.where(saturation.beyond, -1, sweeps.number) if saturation is not None else sweeps.number
    name = readings.runs[int(readings.run[0])].name
    holdout = readings.runs[int(readings.run[0])].holdout
    if sweeps.count == 0 or not (used >= 0).any():
        why = why_no_sweep(angle, torque, saturation)
        return replace(_unusable_run(readings, chain), left_out=why, saturation=saturation)
    branches = average_branches(angle, torque, used, sweeps.up, N_BINS)
    has_two_clocks = bool(readings.two_clocks[int(readings.run[0])])
    try:
        fit = fit_series(branches, with_lag=has_two_clocks)
    except InputError as error:
        # a description of one run: the parameters are fitted to its states all the same
        if error.code is not FaultCode.NO_CONVERGENCE:
            raise
        return replace(_unusable_run(readings, chain), left_out=error.reason, saturation=saturation)
    segment = play_segment(fit.law) if fit.play_found else None
    step = encoder_step(readings.joints[:, chain.joint - 1])
    outer = segment.outer_slope if segment is not None else abs(fit.law.curve[0])
    noise = np.sqrt(2.0) * NORMAL_95 * branches.noise / max(outer, 1e-12)
    # between two readings nothing is known of the curve, whatever the law that is fitted makes of it
    spacing = _distance_about_the_crossing(angle[used >= 0], torque[used >= 0])
    return ClampedRun(
        name=name,
        joint=chain.joint,
        holdout=holdout,
        chain=chain,
        sweeps=sweeps,
        branches=branches,
        fit=fit,
        segment=segment,
        cycle_spread=_between_cycles(angle, torque, used, sweeps, fit),
        motion=float(np.ptp(angle[sweeps.number >= 0])),
        encoder_step=step,
        resolution=float(np.linalg.norm([step, noise, spacing])),
        reversal=reversal_error(angle, torque, sweeps.number, sweeps.up),
        saturation=saturation,
        others_share=chain.share_of_others(laws),
        left_out="" if not holdout else "held out",
    )


def _distance_about_the_crossing(angle: Floats, torque: Floats) -> float:
    """Return the mean distance of angles in the middle quarter of the torque, rad, all cycles together."""
    middle = 0.5 * float(torque.max() + torque.min())
    near = np.abs(torque - middle) <= 0.125 * np.ptp(torque)
    return 0.25 * float(np.ptp(angle)) / max(int(np.count_nonzero(near)) - 1, 1)


def _unusable_run(readings: ClampedReadings, chain: ClampedChain) -> ClampedRun:
    """Return a run that carries no information on its joint."""
    name = readings.runs[int(readings.run[0])].name
    nothing = Branches(*(np.zeros(0),) * 2, np.zeros(0, dtype=np.bool_), np.zeros(0), np.zeros(0, dtype=np.int64), 0.0)
    law = TorqueAngleLaw(0.0, 0.0, 1.0, 0.0, 0.0, 0.0, (0.0, 0.0, 0.0), (0.0, 0.0))
    none = np.zeros(len(readings), dtype=np.int64) - 1
    return ClampedRun(
        name, chain.joint, False, chain, Sweeps(none, none > 0, 0), nothing,
        SeriesFit(law, np.zeros((9, 9)), 0.0, 0, play_found=False), None, float("nan"),
        float(np.ptp(chain.motion[:, chain.joint - 1])), 0.0, float("nan"), None, None, 0.0,
        "in this pose the joint does not load the clamped flange: other joints can yield in the same way",
    )  # fmt: skip


def encoder_step(angle: Floats) -> float:
    """Return the smallest step of an angle log, rad: the spacing of the values that it takes; 0 where none shows.

    Examples
    --------
    >>> encoder_step(np.round(np.linspace(0.0, 1.0, 5000), 2))
    0.01
    """
    values = np.unique(np.round(angle, 12))
    if values.size < 3 or values.size > 0.5 * angle.size:
        return 0.0
    spacing = np.diff(values)
    return float(np.round(np.percentile(spacing, 10), 12))


def _between_cycles(angle: Floats, torque: Floats, used: NDArray[np.int64], sweeps: Sweeps, fit: SeriesFit) -> float:
    """Return how the width scatters from cycle to cycle: one Gauss-Newton step of the fit on each cycle alone."""
    if not fit.play_found or sweeps.cycles < 2:
        return float("nan")
    widths = []
    for cycle in range(sweeps.cycles):
        sweep_of_cycle = np.where((used == 2 * cycle) | (used == 2 * cycle + 1), used - 2 * cycle, -1)
        if (sweep_of_cycle >= 0).sum() < 20:
            continue
        branches = average_branches(angle, torque, sweep_of_cycle, sweeps.up, N_BINS)
        widths.append(fit.law.width + fit.law.width_correction(branches))
    return float(np.std(widths, ddof=1)) if len(widths) > 1 else float("nan")


def judged(runs: Sequence[ClampedRun]) -> list[ClampedRun]:
    """Name and leave out the poses in which the motion barely exceeds the play, or that went one way only."""
    judged_runs = []
    for run in runs:
        peers = [peer for peer in runs if peer.joint == run.joint and peer.branches.angle.size and peer.both_ways]
        reference = _play_of_joint(peers)
        why = run.left_out
        if not why and not run.both_ways:
            why = ONE_WAY
        if not why and run.play > 0.0 and (side := run.fit.law.flank_not_reached):
            why = (
                f"its motion ends within the segment of low slope, the {side} flank is not reached: drive it back and "
                "forth beyond both flanks"
            )
        if not why and reference > 0.0 and run.motion < LEAST_MOTION * reference:
            why = (
                f"the motion, {angle(run.motion)}, barely exceeds the segment of low slope, "
                f"{angle(reference)}: the flanks are not reached"
            )
        judged_runs.append(replace(run, left_out=why))
    return judged_runs


def _play_of_joint(runs: Sequence[ClampedRun]) -> float:
    """Return the play by the poses that moved far beyond their resolution, rad; the widest motion where none."""
    far = [run.play for run in runs if run.motion > 1.5 * run.play > 0.0]
    wide = [run for run in runs if run.motion >= 0.7 * max(candidate.motion for candidate in runs)]
    plays = [run.play for run in wide if run.play in far] or far
    return float(np.median(plays)) if plays else 0.0

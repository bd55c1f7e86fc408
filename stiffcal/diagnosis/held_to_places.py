"""Set-up errors held against absolute places: a target elsewhere, or a turned tracker, shows in the reference states.

What is measured there is a place, not a displacement, so that a target that is 10 mm off is 10 mm off in every pose,
and a tracker turned by a degree misses by centimetres. A candidate whose fitted values the places do not show is no
explanation of the displacements either: another error stands behind it (physics, section 5.8).

How well places show a target's shift and a tracker's turn follows from the tolerance of the robot's geometry, which
makes errors of some tenths of a millimetre to millimetres: generalised least squares of the places' misfit on a shift
and a turn of the tracker and a shift of the target, with that tolerance as covariance.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from stiffcal.arrays import Floats, Integers
from stiffcal.diagnosis.answers.results import AgreementWithPlaces
from stiffcal.diagnosis.refits.heldout_error import with_values_of
from stiffcal.diagnosis.scans.lack_of_fit import relative_std
from stiffcal.diagnosis.scans.load_scan import LoadScan
from stiffcal.diagnosis.thresholds import PLACES_ERRORS
from stiffcal.identification.fitting.fit import Fit
from stiffcal.identification.fitting.geometry import geometry_prior, places_by_geometry, reference_poses, rigid_changes
from stiffcal.measurements.load_states import LoadStates
from stiffcal.model.abilities import FiniteShift
from stiffcal.model.assembled.composite import CompliantRobot, PlacedEffect
from stiffcal.model.balance.equilibrium import solve_balance
from stiffcal.model.effect import Instrument, Observed, StateOrder

# m: what a pose itself adds, bearings and gears that run out, the tracker's own error.
POSE_ERROR = 1e-4
# m, rad, m: shifts and turns of a tracker and shifts of the target that nobody overlooks.
WIDE_TRACKER, WIDE_TARGET = np.repeat([10.0, 0.5], 3), np.repeat(0.5, 3)
# A pattern of which the shift and turns leave more than this is no error of the set-up that places show like one.
RIGID_SHARE = 0.9
# Poses beyond this number say little more and cost the cube of their number.
MOST_POSES = 150


@dataclass(frozen=True)
class ReferencePlaces:
    """Absolute places of a campaign's reference states, and what they show of the set-up."""

    states: LoadStates
    """The campaign's load states."""
    chosen: Integers
    """(n,) reference states, one per pose."""
    angles: Floats
    """(J, n) rad, model angles there."""
    estimator: Floats
    """(6T + 3, 3n) maps places to the shifts and turns of trackers and the shift of the target that fit them best."""
    covariance: Floats
    """(6T + 3, 6T + 3) of these."""
    contradicted: bool
    """Whether places contradict the robot file: then they show nothing of the set-up."""

    @classmethod
    def of(cls, states: LoadStates, fit: Fit) -> ReferencePlaces | None:
        """Prepare; None where no absolute places were measured, or in too few poses."""
        chosen = reference_poses(states)
        if chosen is None:
            return None
        chosen = chosen[:: -(-len(chosen) // MOST_POSES)]
        chain = fit.robot.chain
        angles, target = chain.model_angles(states.joints[chosen]), states.setup.targets[0]
        prior = geometry_prior(states, fit.robot)
        spread = places_by_geometry(chain, angles, target) * prior.sizes(chain.n_joints)
        covariance = spread @ spread.T + POSE_ERROR**2 * np.eye(len(spread))
        design = rigid_changes(chain, angles, target, states.tracker[chosen])
        weighed = np.linalg.solve(covariance, design).T
        wide = np.append(np.tile(WIDE_TRACKER, design.shape[1] // 6), WIDE_TARGET)
        posterior = np.linalg.inv(weighed @ design + np.diag(1.0 / wide**2))
        return cls(
            states,
            chosen,
            angles,
            np.asarray(posterior @ weighed),
            np.asarray(posterior),
            prior.contradicted(chain.masses_known),
        )

    def agreement(self, robot: CompliantRobot, placed: PlacedEffect, std: float) -> AgreementWithPlaces | None:
        """Return how places agree with an effect's values; None where they cannot show it.

        Parameters
        ----------
        robot : with values and with the effect.
        placed : the effect, one of the robot's.
        std : standard uncertainty of the effect's size, as a share of it.
        """
        if not isinstance(placed.effect, Instrument) or self.contradicted:
            return None
        still = np.zeros((len(self.chosen), 6))
        bare = replace(robot, placed=tuple(other for other in robot.placed if other is not placed))
        expected, changed = (
            solve_balance(model, self.angles, still, self.states.setup).unloaded_position[:, 0]
            for model in (bare, robot)
        )
        shift = changed + _tracker_shift(placed, expected) - expected
        if np.abs(shift).max() == 0.0:
            return None
        misfit = self.states.position[self.chosen, 0] - expected
        fitted, found = self.estimator @ shift.ravel(), self.estimator @ misfit.ravel()
        chain, target = robot.chain, self.states.setup.targets[0]
        parts = rigid_changes(chain, self.angles, target, self.states.tracker[self.chosen]) * fitted
        columns = np.arange(len(fitted))
        # of each tracker a shift and a turn, then the target's shift
        turns, of_target = columns[:-3].reshape(-1, 2, 3)[:, 1].ravel(), columns[-3:]
        sizes = [float(np.linalg.norm(parts[:, part].sum(axis=1))) for part in (turns, of_target)]
        part = turns if sizes[0] > sizes[1] else of_target
        if max(sizes) < RIGID_SHARE * float(np.linalg.norm(shift - shift.mean(axis=0))):
            return None
        weight = np.linalg.solve(self.covariance[np.ix_(part, part)], fitted[part])
        scale = float(weight @ fitted[part])
        uncertainty = float(np.hypot(1.0 / np.sqrt(scale), std))
        share = float(weight @ found[part]) / scale
        contradicted = 1.0 - share > PLACES_ERRORS * uncertainty
        return AgreementWithPlaces(
            share=share,
            std=uncertainty,
            contradicted=contradicted,
            supported=not contradicted and share > PLACES_ERRORS * uncertainty,
        )


def held_to_places(scan: LoadScan, places: ReferencePlaces | None) -> LoadScan:
    """Return a scan whose set-up errors carry what absolute places show of them."""
    if places is None:
        return scan
    trials = []
    for trial in scan.trials:
        if trial.candidate.place.kind == "setup" and isinstance(trial.candidate.effect, Instrument):
            robot = with_values_of(scan, trial)
            trial = replace(trial, places=places.agreement(robot, robot.placed[-1], relative_std(trial)))
        trials.append(trial)
    return replace(scan, trials=tuple(trials))


def _tracker_shift(placed: PlacedEffect, places: Floats) -> Floats:
    """Return (n, 3) what an observation law does to places, counted from their centre, as it does to displacements."""
    n = len(places)
    nothing = np.zeros(n)
    order = StateOrder(np.arange(n), nothing, nothing, np.zeros((0, n)), nothing, nothing)
    of_targets = np.zeros((1, 6, n))
    of_targets[0, :3] = (places - places.mean(axis=0)).T
    effect = placed.effect
    if not isinstance(effect, FiniteShift):
        return np.zeros_like(places)
    return np.asarray(effect.observation_shift(placed.place, Observed(of_targets, order), placed.values)[0, :3].T)

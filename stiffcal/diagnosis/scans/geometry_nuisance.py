"""Errors of the robot's geometry as nuisance columns of the scan: candidates explain what the geometry cannot.

Lengths that are off by half a millimetre and axes turned by a fiftieth of a degree change the lever of every load in
every pose alike. Of many readings that is a structure well above the noise, and the effect that comes nearest would be
named for it. So the directions in which the geometry's tolerance shows most stand next to the model's own columns, each
with a prior of unit variance: ridge regression on them alone, the same for every candidate (Hoerl and Kennard 1970; as
in Rasmussen and Williams, Gaussian Processes for Machine Learning, 2006, section 2.7). Poses left out judge it like
everything else.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stiffcal.arrays import Booleans, Floats
from stiffcal.diagnosis.thresholds import DEPENDENT
from stiffcal.identification.fitting.fit import Fit
from stiffcal.identification.fitting.geometry import geometry_columns, geometry_prior, geometry_slope
from stiffcal.identification.noise.projection import Projection
from stiffcal.identification.readings.row_layout import MOTOR
from stiffcal.identification.readings.starting import starting_runs
from stiffcal.measurements.load_states import LoadStates
from stiffcal.model.assembled.composite import CompliantRobot

# Directions whose tolerance adds less than this to all readings together, in units of the noise, change no answer: a
# candidate is supported from some five units on …
LEAST_SHOWN = 0.5
# … and of the others the foremost are enough: what the tolerance makes falls off by two from the first to the eighth.
MOST_DIRECTIONS = 16
# Sag of a joint under the robot's weight, rad.
USUAL_SAG = 5e-3


@dataclass(frozen=True)
class GeometryNuisance:
    """What the geometry's tolerance makes in the readings of a campaign."""

    robot: CompliantRobot
    """Robot with values, whose geometry is varied."""
    sizes: Floats
    """(6J,) standard deviations, m and rad, in the order of `geometry_changes`."""
    chosen: Booleans | None
    """(n,) states in which the directions are looked for; None for all."""
    columns: Floats
    """(6J, m, n') what one standard deviation of each makes in the chosen states."""
    sag: Floats
    """(r, m, n) what one standard deviation of an unknown sag makes in the readings of each of r clamped runs."""

    @classmethod
    def of(cls, states: LoadStates, fit: Fit) -> GeometryNuisance | None:
        """Return it for a campaign; None where absolute places contradict the robot file, by nobody knows how much.

        Parameters
        ----------
        states : the campaign's load states.
        fit : of the model with which the search begins.
        """
        prior = geometry_prior(states, fit.robot)
        if prior.contradicted(fit.robot.chain.masses_known):
            return None
        sizes = prior.sizes(fit.robot.chain.n_joints)
        chosen = starting_runs(fit.data.run)
        data = fit.data if chosen is None else fit.data.subset(chosen)
        columns = geometry_columns(fit.robot, data) * sizes[:, None, None]
        return cls(fit.robot, sizes, chosen, columns, unknown_sag(fit))

    def directions(self, space: Projection, own: Floats) -> Floats:
        """Return (q, m, n) columns of unit prior variance: the directions that show beyond a model's own columns.

        Parameters
        ----------
        space : whitening and runs of all states.
        own : (p, m, n) the model's own columns.
        """
        return np.concatenate([self._of_geometry(space, own), self.sag])

    def _of_geometry(self, space: Projection, own: Floats) -> Floats:
        part, known, times = space, own, 1.0
        if self.chosen is not None:
            data = space.data.subset(self.chosen)
            part, known = Projection.of(data, space.whitening.subset(self.chosen)), own[:, :, self.chosen]
            times = float(np.sqrt(len(self.chosen) / np.count_nonzero(self.chosen)))
        rows = part.rows(np.concatenate([known, self.columns]))
        rows /= np.maximum(np.linalg.norm(rows, axis=1, keepdims=True), 1e-300) ** (
            np.arange(len(rows)) < len(known)
        )[:, None]  # fmt: skip
        basis, triangle = np.linalg.qr(rows[: len(known)].T)
        independent = np.abs(np.diagonal(triangle)) > DEPENDENT
        basis, rest = basis[:, independent], rows[len(known) :].T
        _, values, axes = np.linalg.svd(rest - basis @ (basis.T @ rest), full_matrices=False)
        axes = axes[:MOST_DIRECTIONS][times * values[:MOST_DIRECTIONS] > LEAST_SHOWN]
        if self.chosen is None or not len(axes):
            return np.einsum("qg,gmn->qmn", axes, self.columns) if len(axes) else own[:0]
        return np.stack([geometry_slope(self.robot, space.data, axis * self.sizes) for axis in axes])


def unknown_sag(fit: Fit) -> Floats:
    """Return (r, m, n) what the sag changes in each clamped run's readings; none where all compliances are known.

    A joint that was not driven shows nothing of its compliance. Under the weight of what is outboard of it the robot
    had sagged by some milliradians when it was clamped, in each position by others, and by that much differs the
    Jacobian by which the driven motor reads its joint.
    """
    data, chain = fit.data, fit.robot.chain
    motors = data.rows_of(MOTOR)
    clamped = np.any(data.measured_mask[motors], axis=0)
    compliances = [parameter for parameter in fit.parameters if parameter.spec.compliance and parameter.value]
    known = {joint for parameter in compliances for joint in parameter.place.joints}
    if not clamped.any() or not chain.masses_known or chain.n_joints == 1 or len(known) == chain.n_joints:
        return np.zeros((0, *data.measured.shape))
    runs = np.unique(data.run[clamped])
    columns = np.zeros((len(runs), *data.measured.shape))
    for number, run in enumerate(runs):
        rows = np.ix_(motors, np.flatnonzero(clamped & (data.run == run)))
        columns[number][rows] = USUAL_SAG * fit.predicted[rows]
    return columns

"""What errors of the robot's geometry leave in the estimates: they are common to all rows, and no noise per row.

A link that is half a millimetre longer than the robot file has it changes the lever of every load in every pose. The
fit answers with other compliances, B g for small errors g of the geometry: B is the least-squares solution with the
slope of the prediction by g in place of the residual. With a prior of g the estimates' covariance grows by B Σ Bᵀ
(Jaynes, Probability Theory, 2003, ch. 8, on nuisance parameters; systematic effects in GUM 2008, 5.2). The estimates
themselves, the noise and the residuals stay as they are: what the geometry leaves in the residuals remains there.

Where a tracker measured absolute places, their misfit scales the prior, up and down.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from stiffcal.arrays import Floats, Integers
from stiffcal.estimation.parameters import reported_parameters, student_95
from stiffcal.estimation.triangular import scaled_inverse, triangular_of_rows
from stiffcal.estimation.unknowns import ParameterColumn
from stiffcal.identification.derivatives.observation import Observations
from stiffcal.identification.derivatives.state_blocks import depends_on_run
from stiffcal.identification.fitting.fit import Fit
from stiffcal.identification.fitting.geometry_prior import GeometryPrior
from stiffcal.identification.fitting.geometry_source import GeometrySource
from stiffcal.identification.fitting.load_rows import LoadRows
from stiffcal.identification.noise.reading_noise import Whitening
from stiffcal.identification.noise.weights import predict_observations
from stiffcal.identification.readings.starting import starting_states, states_of_long_runs
from stiffcal.measurements.load_states import Attachment, LoadStates
from stiffcal.mechanics.chain import Chain, GeometryTolerance
from stiffcal.mechanics.kinematics import attached_poses
from stiffcal.mechanics.rotations import rotation_from_vector
from stiffcal.model.assembled.composite import CompliantRobot
from stiffcal.model.balance.equilibrium import solve_balance
from stiffcal.uncertainty import NORMAL_95

# Steps of the differences, m and rad: the prediction is straight in them to a ten-thousandth.
STEP = 1e-5
# So many squares of a standard normal the prior of the scale counts: places in few poses do not overrule it.
PRIOR_DOF = 4.0
# Squared length of three standard normals: median over mean.
MEDIAN_OF_MEAN = 0.789
# Poses whose joints agree to this are one pose, rad.
SAME_POSE = 1e-3
# A rigid motion of the tracker and a shift of the target on the flange say nothing on the robot.
LEAST_POSES = 6


def geometry_changes(chain: Chain) -> list[Chain]:
    """Return 6J chains, joint by joint shifted along and turned about the axes of its frame by `STEP`."""
    chains = []
    for joint in range(chain.n_joints):
        for component in range(6):
            small = np.eye(4)
            vector = np.zeros(3)
            vector[component % 3] = STEP
            if component < 3:
                small[:3, 3] = vector
            else:
                small[:3, :3] = rotation_from_vector(vector)
            fixed = chain.fixed.copy()
            fixed[joint] = fixed[joint] @ small
            chains.append(replace(chain, fixed=fixed))
    return chains


def geometry_columns(robot: CompliantRobot, data: Observations) -> Floats:
    """Return (6J, m, n) derivatives of the readings by the geometry, m and rad, on the chain as drawn.

    The balance of the deformed chain changes them by a per cent, of an uncertainty.
    """
    linear = replace(robot, deformed=False)
    nominal = predict_observations(linear, data)
    columns = []
    for chain in geometry_changes(robot.chain):
        moved = replace(linear, chain=chain)
        columns.append((predict_observations(moved, data) - nominal) / STEP)
    return np.stack(columns)


def geometry_slope(robot: CompliantRobot, data: Observations, change: Floats) -> Floats:
    """Return (m, n) what a small change of the whole geometry makes in the readings, as `geometry_columns` does.

    ``change`` (6J,) is in the order of `geometry_changes`, m and rad.
    """
    linear = replace(robot, deformed=False)
    small = np.tile(np.eye(4), (robot.chain.n_joints, 1, 1))
    step = change.reshape(-1, 6) * (STEP / np.abs(change).max())
    small[:, :3, 3], small[:, :3, :3] = step[:, :3], rotation_from_vector(step[:, 3:])
    fixed = robot.chain.fixed.copy()
    fixed[: len(small)] = fixed[: len(small)] @ small
    moved = replace(linear, chain=replace(robot.chain, fixed=fixed))
    difference = predict_observations(moved, data) - predict_observations(linear, data)
    return np.asarray(difference * (np.abs(change).max() / STEP))


def geometry_effect(
    robot: CompliantRobot, data: Observations, columns: Sequence[ParameterColumn], whitening: Whitening
) -> Floats:
    """Return (p, 6J) what errors of the geometry do to p amplitudes that are free, per m and rad.

    What is common to all rows does not shrink with their number: of large campaigns some runs show it, of long runs
    some states.

    Parameters
    ----------
    robot : with values.
    data : the observations that it was fitted to.
    columns : the p amplitudes.
    whitening : weights of the fit.
    """
    chosen = starting_states(data)
    if chosen is None and not depends_on_run(robot, data):
        chosen = states_of_long_runs(data)
    if chosen is not None:
        data, whitening = data.subset(chosen), whitening.subset(chosen)
    about = LoadRows.about(robot, data, columns, whitening)
    factor = triangular_of_rows(about.space.rows(np.concatenate([about.derivative, geometry_columns(robot, data)])))
    return np.asarray(scaled_inverse(factor[:, : len(columns)]) @ factor[:, len(columns) :])


def geometry_prior(states: LoadStates, robot: CompliantRobot) -> GeometryPrior:
    """Return how well the geometry is known: as the robot file states, else the default, scaled by absolute places.

    Parameters
    ----------
    states : with the reference states' places, where a tracker measured them.
    robot : with values: the places are those of the robot as it sags.
    """
    tolerance = robot.chain.tolerance
    places = misfit_of_places(states, robot, tolerance)
    if tolerance.stated:
        misfit = None if places is None else places[0]
        return GeometryPrior(tolerance.length, tolerance.angle, GeometrySource.ROBOT_FILE, misfit)
    if places is None:
        return GeometryPrior(tolerance.length, tolerance.angle, GeometrySource.DEFAULT)
    misfit, dof = places
    scale = float(np.sqrt((PRIOR_DOF + dof * misfit**2) / (PRIOR_DOF + dof)))
    return GeometryPrior(scale * tolerance.length, scale * tolerance.angle, GeometrySource.PLACES, misfit)


def reference_poses(states: LoadStates) -> Integers | None:
    """Return (n,) reference states with a measured place, the first of each pose; None of too few poses."""
    if states.deflection_given or not states.setup.targets:
        return None
    measured = np.isfinite(states.position[:, 0]).all(axis=1) & states.reference & states.used
    chosen = np.flatnonzero(measured)
    if len(chosen):
        _, first = np.unique(np.round(states.joints[chosen] / SAME_POSE), axis=0, return_index=True)
        chosen = chosen[np.sort(first)]
    return chosen if len(chosen) >= LEAST_POSES else None


def rigid_changes(chain: Chain, angles: Floats, target: Attachment, tracker: Integers) -> Floats:
    """Return (3n, 6T + 3) what shifts and turns of trackers (base axes) and a shift of the target make in its places.

    Per m, rad (about the base's origin) of each tracker, and m.

    Parameters
    ----------
    angles : (n, J) model angles, rad. tracker : (n,) which of the T trackers read each place.
    """
    position, rotation = attached_poses(chain, angles, target)
    shift = np.tile(np.eye(3), (len(position), 1, 1))
    turn = np.cross(np.eye(3)[None], position[:, None, :]).swapaxes(1, 2)
    rigid = np.concatenate([shift, turn], axis=2)
    own = [np.where((tracker == number)[:, None, None], rigid, 0.0) for number in np.unique(tracker)]
    return np.concatenate([*own, rotation], axis=2).reshape(3 * len(position), -1)


def places_by_geometry(chain: Chain, angles: Floats, target: Attachment) -> Floats:
    """Return (3n, 6J) derivatives of a target's places by the geometry, in the order of `geometry_changes`."""
    position, _ = attached_poses(chain, angles, target)
    moved = (attached_poses(changed, angles, target)[0] for changed in geometry_changes(chain))
    return np.stack([(place - position).ravel() / STEP for place in moved], axis=1)


def misfit_of_places(
    states: LoadStates, robot: CompliantRobot, tolerance: GeometryTolerance
) -> tuple[float, float] | None:
    """Return how many times the tolerance absolute places miss by, and its degrees of freedom; None of few poses.

    The median over poses bears a pose that is mislabelled. A rigid motion of the tracker's frame and a shift of the
    target on its body are taken out first.
    """
    chosen = reference_poses(states)
    if chosen is None:
        return None
    angles = robot.chain.model_angles(states.joints[chosen])
    target = states.setup.targets[0]
    rest = solve_balance(robot, angles, np.zeros((len(chosen), 6)), states.setup)
    away = states.position[chosen, 0] - rest.unloaded_position[:, 0]
    gauge = rigid_changes(robot.chain, angles, target, states.tracker[chosen])
    prior = GeometryPrior(tolerance.length, tolerance.angle, GeometrySource.DEFAULT)
    spread = places_by_geometry(robot.chain, angles, target) * prior.sizes(robot.chain.n_joints)
    basis, values, _ = np.linalg.svd(gauge, full_matrices=False)
    basis = basis[:, values > 1e-9 * values[0]]
    spread = spread - basis @ (basis.T @ spread)
    left = away.ravel() - basis @ (basis.T @ away.ravel())
    expected = np.sum(spread**2, axis=1).reshape(-1, 3).sum(axis=1)
    if not expected.min() > 0.0:
        return None
    found = float(np.median(np.sum(left.reshape(-1, 3) ** 2, axis=1) / expected)) / MEDIAN_OF_MEAN
    singular = np.linalg.svd(spread, compute_uv=False) ** 2
    dof = float(singular.sum() ** 2 / np.sum(singular**2))
    return float(np.sqrt(found)), dof


def with_geometry(fit: Fit, states: LoadStates) -> Fit:
    """Return the fit with the geometry's tolerance in its covariance and in the parameters' uncertainties.

    Values, residuals and noise stay. Combinations of parameters that are not distinguished keep their uncertainty.

    Parameters
    ----------
    fit : from `identify_parameters`.
    states : the campaign's load states, whose absolute places show how well the geometry is known.
    """
    if states.absolute.any():
        return fit  # the geometry is measured by the same places, and is in the model or in the residual
    robot = fit.robot
    prior = geometry_prior(states, robot)
    sizes = prior.sizes(robot.chain.n_joints)
    if not sizes.any() or not fit.free_names:
        return replace(fit, geometry=prior)
    columns = fit.columns
    names = [robot.placed[column.placed].parameter_name(column.symbol) for column in columns]
    effect = geometry_effect(robot, fit.data, columns, fit.whitening)
    spread_by_geometry = effect[[names.index(name) for name in fit.free_names]] * sizes
    from_geometry = spread_by_geometry @ spread_by_geometry.T
    covariance = fit.covariance + from_geometry
    variance = np.diag(covariance)
    spread = dict(zip(fit.free_names, np.sqrt(variance).tolist(), strict=True))
    # of what no degree of freedom determines the variance is infinite, and no share of it is known
    known = np.isfinite(variance)
    shares = np.diag(from_geometry)[known] / np.maximum(variance[known], 1e-300)
    share = dict(zip(np.array(fit.free_names)[known].tolist(), shares.tolist(), strict=True))
    quantile = student_95(fit.dof) if fit.scaled else NORMAL_95
    parameters = reported_parameters(robot, spread, quantile, fit.fixed)
    return replace(
        fit,
        parameters=tuple(replace(p, from_geometry=share.get(p.name)) for p in parameters),
        covariance=covariance,
        covariance_from_geometry=from_geometry,
        geometry=prior,
    )

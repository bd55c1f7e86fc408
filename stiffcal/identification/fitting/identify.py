"""From load states to a fit: Gauss–Newton on the fit in equilibrium, weights from the noise.

The steps: a first-order fit on the rigid chain gives a start; with it the wrench's noise is carried through the model
and repeats give the noise; then Gauss–Newton steps on the finite balance, until a step is small against the standard
uncertainties. Parameters that the data cannot distinguish are left out of the last steps and named.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from stiffcal.arrays import Booleans, Floats
from stiffcal.errors import Progress, no_progress
from stiffcal.estimation.identifiability import Ambiguity
from stiffcal.estimation.parameters import reported_parameters, student_95
from stiffcal.estimation.solve import Settled, settle
from stiffcal.estimation.step import solve_step
from stiffcal.estimation.undetermined import Undetermined
from stiffcal.estimation.unknowns import OpenBefore, Unknowns, amplitudes, free_columns, with_estimates
from stiffcal.identification.derivatives.observation import Observations, observe
from stiffcal.identification.fitting.base_load import loaded_by_tilt
from stiffcal.identification.fitting.fit import Fit
from stiffcal.identification.fitting.gauge import held_frames, redundant_geometry
from stiffcal.identification.fitting.load_rows import LoadRows
from stiffcal.identification.fitting.load_scale import common_scale, redundant_gains
from stiffcal.identification.fitting.load_source import LoadSource, LoadWeights
from stiffcal.identification.fitting.nonlinear_start import lacks_nonlinear_value, start_nonlinear
from stiffcal.identification.fitting.problem import Problem
from stiffcal.identification.fitting.settings import Settings
from stiffcal.identification.noise.noise_dominated import noise_dominated_parameters
from stiffcal.identification.noise.reading_noise import (
    Noise,
    noise_of_clamped,
    rms_by_measure,
    rms_length,
    stated_noise,
)
from stiffcal.identification.noise.weights import (
    offset_free_residual,
    predict_observations,
    raw_whitening,
    without_offsets,
)
from stiffcal.identification.readings.repeated_places import repeated_places
from stiffcal.identification.readings.row_layout import MOTOR
from stiffcal.identification.readings.starting import starting_runs, starting_states
from stiffcal.identification.readings.undriven import undriven_parameters
from stiffcal.measurements.load_states import LoadStates
from stiffcal.model.assembled.composite import CompliantRobot
from stiffcal.model.assembled.measured_frames import FramePosition
from stiffcal.model.effect import ParameterRole
from stiffcal.reduction.loads.cycles import find_load_cycles, repeat_groups
from stiffcal.uncertainty import NORMAL_95

__all__ = [
    "Problem", "Settings", "fit_observations", "fit_problem", "fit_rms", "identify_parameters",
    "offset_free_residual", "predict_observations", "raw_whitening",
]  # fmt: skip


# Standard uncertainties of a reading, rms, by which predictions may be off.
SMALL_MOTION = 1e-2


def fit_problem(states: LoadStates, robot: CompliantRobot, keep: Booleans | None = None) -> Problem:
    """Prepare load states for a fit; runs marked ``holdout`` are left out.

    Parameters
    ----------
    keep : (n,) further states to keep, or None for all.
    """
    allowed = np.array([not info.holdout for info in states.runs], dtype=np.bool_)[states.run]
    if keep is not None:
        allowed &= keep
    data = observe(states, robot.chain)
    if not allowed.all():
        data = data.subset(allowed[data.index])
    stated = stated_noise(states.setup.sigma, data)
    if stated is None and data.absolute.any() and data.absolute.all():
        return Problem(data, tuple(repeated_places(data)), stated)
    return Problem(data, tuple(_repeats(states, data)), stated)


def _repeats(states: LoadStates, data: Observations) -> Iterator[NDArray[np.int64]]:
    """Give positions in ``data`` of states that repeat each other, in large campaigns of some runs only."""
    chosen = starting_runs(data.run)
    looked_at = np.arange(len(states))
    if chosen is not None:
        looked_at = np.flatnonzero(np.isin(states.run, data.run[chosen]))
        states = states.select(looked_at)
    position = np.full(int(data.index.max(initial=0)) + 1, -1, dtype=np.int64)
    position[data.index] = np.arange(data.n_states)
    for group in repeat_groups(states, find_load_cycles(states)):
        members = looked_at[group]
        members = position[members[members < len(position)]]
        members = members[members >= 0]
        if len(members) > 1:
            yield members


def identify_parameters(
    states: LoadStates, robot: CompliantRobot, settings: Settings | None = None, progress: Progress = no_progress
) -> Fit:
    """Return the fit of a robot's free parameters to its load states.

    Parameters
    ----------
    states : load states; those set aside and runs held out are not used.
    robot : chain and effects; values that are set are where the fit starts.
    settings : see `Settings`.
    progress : called with what is being done.
    """
    problem, settings = fit_problem(states, robot), settings or Settings()
    prior_noise = settings.noise or _noise_known_before(problem)
    fit = fit_observations(problem, robot, _without_noise_dominated(problem, robot, settings, prior_noise), progress)
    if prior_noise is None and fit.noise is not None:
        without_dominated = _without_noise_dominated(problem, robot, settings, fit.noise)
        return fit if without_dominated == settings else fit_observations(problem, robot, without_dominated, progress)
    return fit


def without_noise_dominated(problem: Problem, robot: CompliantRobot, settings: Settings) -> Settings:
    """Return the settings with what only the wrench's noise turns, where that noise is known before any fit.

    So it is where it is stated, and where nothing but clamped motors was read.
    """
    return _without_noise_dominated(problem, robot, settings, _noise_known_before(problem))


def _noise_known_before(problem: Problem) -> Noise | None:
    if problem.stated is None and problem.data.clamped is not None and bool(np.all(problem.data.kind == MOTOR)):
        return noise_of_clamped(problem.data.clamped)
    return problem.stated


def _without_noise_dominated(
    problem: Problem, robot: CompliantRobot, settings: Settings, noise: Noise | None
) -> Settings:
    """Return the settings with what only the wrench's noise turns, as far as that noise is known."""
    if noise is None:
        return settings
    names = noise_dominated_parameters(_starting_problem(problem).data, robot, settings.fixed, noise)
    return replace(settings, noise_dominated=settings.noise_dominated | names)


def fit_observations(
    problem: Problem, robot: CompliantRobot, settings: Settings, progress: Progress = no_progress
) -> Fit:
    """Identify from prepared observations; see `identify_parameters`."""
    first = _starting_problem(problem)
    open_before = _open_before(problem, first, robot, settings)
    progress("first-order fit", 0.1)
    # of thinned sweeps only what begins the fit is wanted, not where their own wrenches are corrected to
    near = first is not problem and first.data.clamped is not None
    start = _initial_estimate(first, robot, settings, open_before)
    source = LoadSource.of(first, start, settings, open_before)
    settled = settle(source, amplitudes(start, source.columns), None, progress, near)
    if first is not problem:
        source = LoadSource.of(problem, start, settings, open_before, settled.weights.weights)
        settled = settle(source, settled.values, settled, progress)
    return _summarise(source, settled)


def _open_before(problem: Problem, first: Problem, robot: CompliantRobot, settings: Settings) -> OpenBefore:
    """Return what no reading determines; of the causes of one parameter the first that is listed counts.

    Parameters
    ----------
    problem : all observations. first : of them those that the fit starts from.
    """
    data, fixed = first.data, settings.fixed
    held = held_frames(robot, data, fixed)
    causes = (
        (redundant_gains(robot, data, fixed), Undetermined.GAIN_OF_LOAD),
        (redundant_geometry(robot, data, fixed | held), Undetermined.SAME_MOTION),
        (held, Undetermined.ONE_ORIENTATION),
        (undriven_parameters(robot, problem.data), Undetermined.UNDRIVEN),
        (loaded_by_tilt(robot, data, fixed), Undetermined.TILT_LOADED),
        (settings.noise_dominated, Undetermined.WRENCH_NOISE),
    )
    found = OpenBefore(common_scale=common_scale(robot, data, fixed))
    for names, cause in causes:
        found = found.with_causes(names, cause)
    return found


def _starting_problem(problem: Problem) -> Problem:
    """Return the problem of some runs or states, enough to start from; a small problem as it is."""
    data = problem.data
    chosen = starting_states(data)
    if chosen is None:
        return problem
    place = np.cumsum(chosen) - 1
    groups = tuple(place[group] for group in problem.groups if chosen[group].all())
    return Problem(data.subset(chosen), groups, problem.stated)


def _initial_estimate(
    problem: Problem, robot: CompliantRobot, settings: Settings, open_before: OpenBefore
) -> CompliantRobot:
    """Return where Gauss–Newton starts: amplitudes by least squares on the rigid chain, which is linear in them.

    Nonlinear parameters without a value are then profiled: for each of their values on a grid the amplitudes are
    solved for, and the value with the least squares is taken (`start_nonlinear`).
    """
    data = problem.data
    whitening = raw_whitening(data, settings.noise or problem.stated)
    columns = [
        c
        for c in free_columns(robot, settings.fixed)
        if c.role is ParameterRole.AMPLITUDE or isinstance(robot.placed[c.placed].effect, FramePosition)
    ]
    without_values = [placed_effect for placed_effect in robot.placed if lacks_nonlinear_value(placed_effect)]
    # Effects whose nonlinear parameters have no value are left out: columns at a typical value would bias the others.
    first_columns = [c for c in columns if robot.placed[c.placed] not in without_values]
    straight = LoadRows.about(replace(robot, deformed=False), data, first_columns, whitening)
    first_step, _ = solve_step(straight.reduced(), Unknowns.of(robot, first_columns, open_before), straight.values)
    start = with_estimates(robot, first_columns, first_step)
    if not without_values:
        return start
    weights = LoadSource.of(problem, start, settings, open_before).weights_at(start)
    return start_nonlinear(start, data, weights.whitening, settings.fixed)


def _summarise(source: LoadSource, settled: Settled[LoadWeights]) -> Fit:
    data, robot, weights = settled.weights.data, source.robot_at(settled.values), settled.weights.weights
    names, settings, reduced, checked = source.unknowns.names, source.settings, settled.reduced, settled.checked
    # predictions are those of where the last step began, as long as it moved them by less than a hundredth of the noise
    moved = settled.moved * np.sqrt(np.count_nonzero(~checked.left_at_neutral) / max(reduced.dof, 1))
    near = robot.deformed and moved < SMALL_MOTION
    predicted = reduced.predicted if near else predict_observations(robot, data)
    residual = without_offsets(data, predicted, settled.weights.whitening)
    white = weights.whitening.apply(residual)
    free, known_ones = ~checked.left_at_neutral, checked.identifiable
    dof = reduced.dof - int(np.count_nonzero(free))
    chi2 = float(np.sum(white**2)) / dof if dof > 0 else np.nan
    noise_known = weights.noise is not None and not settings.equal_weights
    variance = 1.0 if noise_known else chi2
    covariance = reduced.covariance(free) * variance
    quantile = NORMAL_95 if noise_known else student_95(dof)
    free_names = tuple(name for name, is_known in zip(names, known_ones, strict=True) if is_known)
    solved = [name for name, is_free in zip(names, free, strict=True) if is_free]
    ambiguities = tuple(
        _with_value(ambiguity, names, settled.values, solved, covariance) for ambiguity in checked.ambiguities
    )
    identified = known_ones[free]
    covariance = covariance[np.ix_(identified, identified)]
    spread = dict(zip(free_names, np.sqrt(np.diag(covariance)).tolist(), strict=True))
    parameters = tuple(reported_parameters(robot, spread, quantile, settings.fixed))
    noise_length: dict[str, float | None] = {"translation": None, "rotation": None}
    if weights.noise is not None:
        noise_length = rms_length(weights.noise, data, weights.sensitivity)
    return Fit(
        robot=robot,
        parameters=parameters,
        covariance=covariance,
        free_names=free_names,
        condition=checked.condition,
        ambiguities=ambiguities,
        noise=weights.noise,
        noise_length=noise_length,
        scaled=not noise_known,
        reduced_chi2=chi2 if noise_known else None,
        dof=dof,
        residual=residual,
        predicted=np.where(data.measured_mask, data.measured - data.added - residual, 0.0),
        data=data,
        iterations=settled.iterations,
        last_step=settled.last_step,
        whitening=settled.weights.whitening,
        left_at_neutral=frozenset(
            name for name, left_out in zip(names, checked.left_at_neutral, strict=True) if left_out
        ),
    )


def _with_value(
    ambiguity: Ambiguity,
    names: Sequence[str],
    values: Floats,
    solved: Sequence[str],
    covariance: Floats,
) -> Ambiguity:
    """Fill in the value of the combination that is known."""
    if not ambiguity.coefficients:
        return ambiguity
    weight = dict(zip(ambiguity.names, ambiguity.coefficients, strict=True))
    value = values @ [weight.get(name, 0.0) for name in names]
    share = np.array([weight.get(name, 0.0) for name in solved])
    return replace(ambiguity, value=float(value), std=float(np.sqrt(share @ covariance @ share)))


def fit_rms(fit: Fit) -> dict[str, float | None]:
    """Return the residuals' rms length, m and rad."""
    return rms_by_measure(fit.residual**2, fit.data)

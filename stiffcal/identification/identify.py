"""From load states to a fit: Gauss–Newton on the balanced robot, weights from the noise.

The steps: a first-order pass on the rigid chain gives a start; with it the wrench's noise is carried through the model
and repeats tell the noise; then Gauss–Newton steps on the finite balance, until a step is small against the standard
uncertainties. Parameters that the data cannot tell apart are left out of the last steps and named.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from stiffcal.errors import Progress, no_progress
from stiffcal.identification.fit import NORMAL_95, Ambiguity, Fit, Parameter
from stiffcal.identification.identifiability import Identifiability, tell_apart
from stiffcal.identification.least_squares import Reduced, reduce_blocks, take_out_offsets
from stiffcal.identification.noise import (
    ENOUGH_DOF,
    Noise,
    Whitening,
    noise_from_repeats,
    rms_length,
    root_mean_square_length,
    stated_noise,
    whiten,
)
from stiffcal.identification.observation import Column, Observations, evaluate, free_columns, observe
from stiffcal.identification.shapes import lacks_shape, start_shapes
from stiffcal.measurements.load_states import LoadStates
from stiffcal.model.composite import CompliantRobot
from stiffcal.model.effect import ParameterSpec, Place, Sort
from stiffcal.reduction.load_cycles import find_load_cycles, repeat_groups

Floats = NDArray[np.float64]
Booleans = NDArray[np.bool_]

# A step below this share of the standard uncertainty changes nothing that anyone can see.
SMALL_STEP = 1e-4
# Laws with corners (friction, play) make steps rattle at this level, which is as invisible.
SMALL_STEP_OF_SHAPES = 1e-2
MAX_STEPS = 30
# Huber's k: beyond this multiple of the typical length a reading counts less.
HUBER_LIMIT = 2.5
# The wrench's share of the noise follows the compliances; after two steps these stand to a thousandth.
REWEIGHTED_STEPS = 2


@dataclass(frozen=True)
class Settings:
    """How to identify.

    Attributes
    ----------
    loss : "linear" (least squares) or "huber" (readings beyond 2.5 standard uncertainties count less).
    equal_weights : leave the wrench's noise out of the weights: every reading of a kind counts alike.
    fixed : full parameter names that keep the model file's values.
    noise : take this noise instead of estimating it.
    """

    loss: str = "linear"
    equal_weights: bool = False
    fixed: frozenset[str] = field(default_factory=frozenset)
    noise: Noise | None = None


@dataclass(frozen=True)
class Problem:
    """Observations with what is known of their repeats.

    Attributes
    ----------
    data : the observations that may be used to fit.
    groups : positions in ``data`` of states that repeat each other.
    stated : the manifest's noise, or None.
    """

    data: Observations
    groups: tuple[NDArray[np.int64], ...]
    stated: Noise | None


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
    data = data.part(allowed[data.index])
    position = {int(index): place for place, index in enumerate(data.index)}
    groups = []
    for group in repeat_groups(states, find_load_cycles(states)):
        members = np.array([position[int(i)] for i in group if int(i) in position], dtype=np.int64)
        if len(members) > 1:
            groups.append(members)
    return Problem(data, tuple(groups), stated_noise(states.setup.sigma, data))


@dataclass(frozen=True)
class _Step:
    """Where Gauss–Newton stands."""

    robot: CompliantRobot
    noise: Noise | None
    sensitivity: Floats | None
    whitening: Whitening


def identify_parameters(
    states: LoadStates, robot: CompliantRobot, settings: Settings | None = None, progress: Progress = no_progress
) -> Fit:
    """Identify the free parameters of a robot from its load states.

    Parameters
    ----------
    states : load states; those set aside and runs held out are not used.
    robot : chain and effects; values that are set are where the fit starts.
    settings : see `Settings`.
    progress : told what is being done.

    Returns
    -------
    Fit
    """
    return fit_observations(fit_problem(states, robot), robot, settings or Settings(), progress)


def fit_observations(
    problem: Problem, robot: CompliantRobot, settings: Settings, progress: Progress = no_progress
) -> Fit:
    """Identify from prepared observations; see `identify_parameters`."""
    data = problem.data
    progress("first-order pass", 0.1)
    step = _first_pass(problem, robot, settings)
    columns = free_columns(step.robot, settings.fixed)
    amplitude = amplitudes(step.robot, columns)
    iterations, last, robust, weights = 0, np.inf, settings.loss == "huber", step.whitening
    small = SMALL_STEP_OF_SHAPES if any(c.sort is Sort.SHAPE for c in columns) else SMALL_STEP
    while True:
        progress("balanced robot", min(0.9, 0.3 + 0.2 * iterations))
        weights = _huber(step, weights, data) if robust else step.whitening
        reduced = reduce_blocks(evaluate(step.robot, data, columns), data, weights)
        told = _tell_apart(reduced, step.robot, columns)
        updated = _solve(reduced, step.robot, columns, told, start=amplitude)
        # |factor @ Δ| is the step measured in standard uncertainties, whatever their correlations.
        change = float(np.linalg.norm(reduced.factor @ (updated - amplitude)))
        amplitude, iterations = updated, iterations + 1
        step = replace(step, robot=_valued(step.robot, columns, amplitude))
        # Steps contract evenly: the next one is foretold by this one and the ratio to the last.
        foretold = change * min(1.0, change / last) if iterations > 1 else change
        settled = change < small or (foretold < small and not robust)
        if settled or not (robot.deformed or robust) or iterations >= MAX_STEPS:
            break
        if iterations <= REWEIGHTED_STEPS:
            step = _weigh(problem, step.robot, settings)
        last = change
    return _summarise(problem, step, columns, reduced, told, settings, iterations)


def _first_pass(problem: Problem, robot: CompliantRobot, settings: Settings) -> _Step:
    """Return a start: amplitudes from the rigid chain, shapes from a profile about it."""
    data = problem.data
    whitening = raw_whitening(data, settings.noise or problem.stated)
    columns = [c for c in free_columns(robot, settings.fixed) if c.sort is Sort.AMPLITUDE]
    unshaped = [one for one in robot.placed if lacks_shape(one)]
    # Laws whose shape is not known yet wait for it: their columns at some typical shape would mislead the others.
    known = [c for c in columns if robot.placed[c.placed] not in unshaped]
    reduced = reduce_blocks(evaluate(robot, data, known, rigid=True), data, whitening)
    told = _tell_apart(reduced, robot, known)
    start = _solve(reduced, robot, known, told, amplitudes(robot, known))
    step = _weigh(problem, _valued(robot, known, start), settings)
    if not unshaped:
        return step
    return replace(step, robot=start_shapes(step.robot, data, step.whitening, settings.fixed))


def amplitudes(robot: CompliantRobot, columns: Sequence[Column]) -> Floats:
    """Return the free parameters' present values, as the fit counts them."""
    return np.array([robot.placed[c.placed].amplitude(c.symbol) for c in columns], dtype=np.float64)


def raw_whitening(data: Observations, noise: Noise | None) -> Whitening:
    """Return weights for a first look: the stated noise, or each kind of component by its own size."""
    if noise is not None:
        return whiten(noise, data, None)
    size = {}
    for kind in (False, True):
        rows = data.rotational == kind
        values = data.measured[rows][data.seen[rows]]
        size[kind] = float(np.sqrt(np.mean(values**2))) if values.size and values.any() else 1.0
    return whiten(Noise(size[False], size[True], 0.0, 0.0, "none", 0.0), data, None)


def _bounds(robot: CompliantRobot, columns: Sequence[Column]) -> tuple[Floats, Floats]:
    """Return lower and upper bounds of the amplitudes."""
    lower, upper = [], []
    for column in columns:
        low, high = _amplitude_bounds(robot.placed[column.placed].effect.spec(column.symbol))
        lower.append(low)
        upper.append(high)
    return np.array(lower), np.array(upper)


def _amplitude_bounds(spec: ParameterSpec) -> tuple[float, float]:
    if spec.inverse:
        return (1.0 / spec.upper if np.isfinite(spec.upper) else 0.0), (
            1.0 / spec.lower if spec.lower > 0.0 else np.inf
        )
    return spec.lower, spec.upper


def _tell_apart(reduced: Reduced, robot: CompliantRobot, columns: Sequence[Column]) -> Identifiability:
    names = tuple(robot.placed[c.placed].parameter_name(c.symbol) for c in columns)
    lower, upper = _bounds(robot, columns)
    widest = np.where(np.isfinite(upper), np.maximum(np.abs(upper), np.abs(lower)), np.inf)
    shapes = np.array([column.sort is Sort.SHAPE for column in columns], dtype=np.bool_)
    return tell_apart(reduced.factor, names, widest, shapes)


def _solve(
    reduced: Reduced, robot: CompliantRobot, columns: Sequence[Column], told: Identifiability, start: Floats
) -> Floats:
    """Solve for the new amplitudes; those that cannot be told apart stay neutral: at zero, shapes where they are."""
    lower, upper = _bounds(robot, columns)
    free = ~told.held
    shapes = np.array([column.sort is Sort.SHAPE for column in columns], dtype=np.bool_)
    result = np.where(free | shapes, start, 0.0)
    # A law bends with its shape: no step beyond a factor of two.
    lower, upper = (
        np.where(shapes, np.maximum(lower, start / 2), lower),
        np.where(shapes, np.minimum(upper, start * 2), upper),
    )
    if free.any():
        # The reduced target is for the step; bounds hold for the sum.
        target = reduced.target + reduced.factor @ start
        part = Reduced(reduced.factor[:, free], target, 0.0, 0)
        result[free], _ = part.solve_bounded(lower[free], upper[free])
    return result


def _valued(robot: CompliantRobot, columns: Sequence[Column], amplitude: Floats) -> CompliantRobot:
    values: dict[str, float] = {}
    for column, a in zip(columns, amplitude, strict=True):
        one = robot.placed[column.placed]
        spec = one.effect.spec(column.symbol)
        values[one.parameter_name(column.symbol)] = (1.0 / a if a > 0.0 else np.inf) if spec.inverse else float(a)
    return robot.with_values(values)


def _weigh(problem: Problem, robot: CompliantRobot, settings: Settings) -> _Step:
    """Find the noise with the present model, and the weights that follow from it."""
    data = problem.data
    if settings.noise is not None and settings.noise.force == settings.noise.moment == 0.0:
        return _Step(robot, settings.noise, None, whiten(settings.noise, data, None))
    found = list(evaluate(robot, data, (), with_sensitivity=True))
    sensitivity = np.concatenate([block.sensitivity for block in found if block.sensitivity is not None], axis=2)
    predicted = np.concatenate([block.predicted for block in found], axis=1)
    noise = settings.noise
    if noise is None:
        repeats = noise_from_repeats(data, predicted, sensitivity, problem.groups)
        enough = repeats is not None and (repeats.dof >= ENOUGH_DOF or problem.stated is None)
        noise = repeats if enough else problem.stated
    if settings.equal_weights:
        return _Step(robot, noise, None, raw_whitening(data, noise))
    if noise is not None:
        return _Step(robot, noise, sensitivity, whiten(noise, data, sensitivity))
    return _Step(robot, None, sensitivity, whiten(residual_noise(robot, data), data, None))


def residual_noise(robot: CompliantRobot, data: Observations) -> Noise:
    """Return the size of the residuals of translation and rotation, where nothing better is known of the noise."""
    whitening = raw_whitening(data, None)
    residual = offset_free_residual(robot, data, whitening)
    size = []
    for kind in (False, True):
        rows = data.rotational == kind
        values = residual[rows][data.seen[rows]]
        size.append(float(np.sqrt(np.mean(values**2))) if values.size and values.any() else 1.0)
    return Noise(size[0], size[1], 0.0, 0.0, "none", 0.0)


def predict_observations(robot: CompliantRobot, data: Observations) -> Floats:
    """Return (m, n) the model's displacements."""
    return np.concatenate([block.predicted for block in evaluate(robot, data)], axis=1)


def offset_free_residual(robot: CompliantRobot, data: Observations, whitening: Whitening) -> Floats:
    """Return (m, n) measured minus predicted, each run's weighted mean taken out where runs carry offsets."""
    return _without_offsets(data, predict_observations(robot, data), whitening)


def _without_offsets(data: Observations, predicted: Floats | None, whitening: Whitening) -> Floats:
    residual = np.where(data.seen, data.measured - (0.0 if predicted is None else predicted), 0.0)
    if data.free_offset:
        residual = np.where(data.seen, take_out_offsets(residual[None], data.run, whitening)[0][0], 0.0)
    return residual


def _huber(step: _Step, weights: Whitening, data: Observations) -> Whitening:
    """Return weights lowered for readings whose whitened length is beyond 2.5 times the typical one.

    Translation and rotation of a reading are judged apart. The median sets the scale: it bears wild readings, also
    where they have swollen the noise told from repeats.
    """
    white = step.whitening.apply(offset_free_residual(step.robot, data, weights))
    factor = np.ones_like(data.measured)
    for kind in (False, True):
        rows = data.rotational == kind
        length = np.sqrt(np.sum(white[rows] ** 2, axis=0))
        if length.any():
            scale = HUBER_LIMIT * float(np.median(length))
            factor[rows] = np.sqrt(np.minimum(1.0, scale / np.maximum(length, 1e-300)))
    lower = step.whitening.lower
    return Whitening(step.whitening.scale * factor, None if lower is None else lower * factor[:, None])


def _summarise(
    problem: Problem,
    step: _Step,
    columns: Sequence[Column],
    reduced: Reduced,
    told: Identifiability,
    settings: Settings,
    iterations: int,
) -> Fit:
    data = problem.data
    # The last step was a small share of a standard uncertainty: what it moved in the predictions is invisible.
    predicted = predict_observations(step.robot, data) if not step.robot.deformed else reduced.predicted
    residual = _without_offsets(data, predicted, step.whitening)
    white = step.whitening.apply(residual)
    free, known_ones = ~told.held, told.identifiable
    dof = reduced.dof - int(np.count_nonzero(free))
    chi2 = float(np.sum(white**2)) / dof if dof > 0 else np.nan
    known = step.noise is not None and not settings.equal_weights
    variance = 1.0 if known else chi2
    factor = reduced.factor[:, free]
    scale = np.sqrt(np.sum(factor * factor, axis=0))
    inverse = np.linalg.pinv(factor / scale, rcond=1e-13) / scale[:, None]
    covariance = inverse @ inverse.T * variance
    quantile = NORMAL_95 if known else student_95(dof)
    names = tuple(step.robot.placed[c.placed].parameter_name(c.symbol) for c in columns)
    free_names = tuple(name for name, one in zip(names, known_ones, strict=True) if one)
    solved = [name for name, one in zip(names, free, strict=True) if one]
    told_apart = tuple(_with_value(one, step.robot, columns, names, solved, covariance) for one in told.ambiguities)
    kept = known_ones[free]
    covariance = covariance[np.ix_(kept, kept)]
    spread = dict(zip(free_names, np.sqrt(np.diag(covariance)).tolist(), strict=True))
    parameters = tuple(_parameters(step.robot, spread, quantile, settings.fixed))
    noise_length: dict[str, float | None] = {"translation": None, "rotation": None}
    if step.noise is not None:
        noise_length = rms_length(step.noise, data, step.sensitivity)
    return Fit(
        robot=step.robot,
        parameters=parameters,
        covariance=covariance,
        free_names=free_names,
        condition=told.condition,
        ambiguities=told_apart,
        noise=step.noise,
        noise_length=noise_length,
        scaled=not known,
        reduced_chi2=chi2 if known else None,
        dof=dof,
        residual=residual,
        predicted=np.where(data.seen, data.measured - residual, 0.0),
        data=data,
        iterations=iterations,
        held=frozenset(name for name, one in zip(names, told.held, strict=True) if one),
    )


def _with_value(
    ambiguity: Ambiguity,
    robot: CompliantRobot,
    columns: Sequence[Column],
    names: Sequence[str],
    solved: Sequence[str],
    covariance: Floats,
) -> Ambiguity:
    """Fill in the value of the combination that is known."""
    if not ambiguity.coefficients:
        return ambiguity
    weight = dict(zip(ambiguity.names, ambiguity.coefficients, strict=True))
    value = amplitudes(robot, columns) @ [weight.get(name, 0.0) for name in names]
    share = np.array([weight.get(name, 0.0) for name in solved])
    return replace(ambiguity, value=float(value), std=float(np.sqrt(share @ covariance @ share)))


def student_95(dof: int) -> float:
    """Return the two-sided 95 % quantile of Student's t."""
    from scipy.special import stdtrit

    return float(stdtrit(dof, 0.975)) if dof > 0 else np.inf


def _parameters(
    robot: CompliantRobot, spread: Mapping[str, float], quantile: float, fixed: frozenset[str]
) -> list[Parameter]:
    """Turn amplitudes into reported parameters, with intervals kept within what is possible."""
    found = []
    for one in robot.placed:
        for spec in one.effect.parameters:
            name = one.parameter_name(spec.symbol)
            if name in fixed:
                value = one.values.get(spec.symbol, 0.0)
                found.append(Parameter(name, one.effect.name, one.place, spec, value, None, None, True, True, False))
                continue
            if spec.discrete:
                value = one.values.get(spec.symbol, spec.typical)
                found.append(Parameter(name, one.effect.name, one.place, spec, value, None, None, False, True, False))
                continue
            if name not in spread:
                found.append(Parameter(name, one.effect.name, one.place, spec, None, None, None, False, False, False))
                continue
            found.append(
                _estimated(name, one.effect.name, one.place, spec, one.amplitude(spec.symbol), spread[name], quantile)
            )
    return found


def _estimated(
    name: str, effect: str, place: Place, spec: ParameterSpec, amplitude: float, std: float, quantile: float
) -> Parameter:
    low, high = _amplitude_bounds(spec)
    tiny = 1e-9 * max(std, 1e-300)
    at_bound = bool(amplitude <= low + tiny or amplitude >= high - tiny)
    interval = (max(low, amplitude - quantile * std), min(high, amplitude + quantile * std))
    if not spec.inverse:
        return Parameter(name, effect, place, spec, amplitude, std, interval, False, True, at_bound)
    value = 1.0 / amplitude if amplitude > 0.0 else np.inf
    bounds = (1.0 / interval[1], 1.0 / interval[0] if interval[0] > 0.0 else np.inf)
    return Parameter(name, effect, place, spec, value, std * value**2, bounds, False, True, at_bound)


def fit_rms(fit: Fit) -> dict[str, float | None]:
    """Return the residuals' rms length, m and rad."""
    squares = np.where(fit.data.seen, fit.residual**2, 0.0)
    return {
        "translation": root_mean_square_length(squares, fit.data, rotational=False),
        "rotation": root_mean_square_length(squares, fit.data, rotational=True),
    }

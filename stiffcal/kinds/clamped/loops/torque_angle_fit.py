"""Fit of spring, play and friction of one driven joint to averaged branches."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from stiffcal.arrays import Floats, Integers
from stiffcal.errors import InputError, no_progress
from stiffcal.estimation.solve import settle
from stiffcal.estimation.unknowns import Unknowns
from stiffcal.fault_codes import FaultCode
from stiffcal.kinds.clamped.loops.branch_source import BranchSource
from stiffcal.kinds.clamped.loops.branches import Branches
from stiffcal.kinds.clamped.loops.play_starts import play_starts
from stiffcal.kinds.clamped.loops.torque_angle import TorqueAngleLaw, play_segment
from stiffcal.uncertainty import NORMAL_95

# The band tried at first, as a share of the largest torque.
_FIRST_BAND = 0.02
# A crossing that takes more than this share of the torque is no play but a soft spring.
_WIDEST_BAND = 0.12
# The fit goes on from the best two starts, and from the best whose play is narrow, middling and wide (ends of these,
# over half the range), to the end each; the least of the ends counts. Of printed reducers laws with a narrow and with a
# wide play leave nearly as little, and the best start leads to the wrong one in 1 of 6. Of logs drawn by Table 2 of 004
# with 8 to 50 readings a sweep it alone leads to the least misfit of any.
BEST_STARTS, CLASSES = 2, (0.25, 0.75)
# Squares by which a play has to explain more: three further parameters (width, band, zero) by chance gain 3 ± 2.4, and
# misfits that are not noise some more.
_NEEDS_PLAY = 30.0
# By so much a squared misfit grows that 95 % of errors do not exceed it: χ² of one number.
_UNLIKELY = 3.84
# Of the range of angles the least width that is asked for; halved five times on a logarithmic scale, the largest width
# is found to a quarter.
_NARROWEST, _HALVINGS = 1e-3, 5
# Slopes in units of the largest torque and of half the range.
_STEEPEST = 1e3


@dataclass(frozen=True)
class SeriesFit:
    """A law fitted to averaged branches."""

    law: TorqueAngleLaw
    """The fitted law."""
    covariance: Floats
    """(9, 9) of `PARAMETERS`."""
    rms: float
    """N·m, of the residual over the bins."""
    dof: int
    """Bins less parameters."""
    play_found: bool
    """False where the data need no play; ``law.width`` is then 0."""
    settled: bool = True
    """False where the iteration did not converge."""
    at_limit: Mapping[str, tuple[bool, bool]] = field(default_factory=dict)
    """Those of `PARAMETERS` whose search ended at a limit: whether at the lower and whether at the upper one."""
    most_width: float = 0.0
    """rad, the largest width with which the branches agree as well, with 95 % probability."""

    def std(self, name: str) -> float:
        """Return the standard uncertainty of one parameter."""
        return float(np.sqrt(max(self.covariance[PARAMETERS.index(name), PARAMETERS.index(name)], 0.0)))

    @property
    def curve_covariance(self) -> Floats:
        """(3, 3) covariance of p1, p2, p3."""
        return self.covariance[6:, 6:]


SCALED = (
    "middle",
    "width",
    "log band",
    "zero",
    "friction",
    "lag",
    "drag",
    "first slope",
    "slope between",
    "last slope",
)
SLOPES = SCALED[-3:]
CURVE = ("p1", "p2", "p3")
# what a number of the search is called where its name is another one
_SETS = {"log band": ("band",), **dict.fromkeys(SLOPES, CURVE)}
PARAMETERS = ("middle", "width", "band", "zero", "friction", "drag", *CURVE)


@dataclass(frozen=True)
class _Scaled:
    """Branches in units of half the range and of the largest torque, and what is free."""

    data: Branches
    angle_unit: float
    torque_unit: float
    with_play: bool
    with_friction: bool
    with_lag: bool
    held: float | None
    """The width over the range of angles; None where it is free."""


def fit_series(data: Branches, *, with_lag: bool = False) -> SeriesFit:
    """Fit spring, play and friction to averaged branches.

    Play is kept only where the data need it: the misfit without it is larger by far more than its scatter, and the
    segment of low slope exists (`play_segment`). Friction is free where both directions were measured.

    Parameters
    ----------
    data : averaged branches.
    with_lag : let the torque stay behind the angle by a constant angle: two devices, two clocks.

    Raises
    ------
    InputError : the steps of the law that is chosen do not settle.
    """
    both_ways = bool(data.up.any() and not data.up.all())
    without = _fit(data, with_play=False, with_friction=both_ways, with_lag=with_lag and both_ways)
    with_play = _fit(data, with_play=True, with_friction=both_ways, with_lag=with_lag and both_ways)
    # what repeats from cycle to cycle is shape: the scatter between cycles decides, but for misfits of the law itself
    noise = max(data.noise, 0.5 * with_play.rms, 1e-12)
    n = data.angle.size
    gain = n * (without.rms**2 - with_play.rms**2) / noise**2
    segment = play_segment(with_play.law)
    wide = segment is not None and with_play.law.width > 3.0 * with_play.std("width")
    chosen = with_play if gain > _NEEDS_PLAY and wide else without
    if not chosen.settled:
        raise InputError.at(
            FaultCode.NO_CONVERGENCE,
            "campaign.toml", "runs", "the fit of torque over angle of a clamped run does not converge",
            "check its angle and torque for jumps, or exclude the run",
        )  # fmt: skip
    # a width that is needed, but leaves no segment of low slope, is known as well as one that does
    if gain > _NEEDS_PLAY:
        return replace(chosen, most_width=with_play.law.width + NORMAL_95 * with_play.std("width"))
    best = min(without, with_play, key=lambda fit: fit.rms)
    return replace(chosen, most_width=_most_width(data, best.rms, both_ways, with_lag and both_ways))


def _most_width(data: Branches, least: float, with_friction: bool, with_lag: bool) -> float:
    """Return the largest width, rad, with which the branches agree nearly as well, all else fitted.

    Parameters
    ----------
    least : N·m, rms of the best fit.
    """
    noise, n = max(data.noise, least, 1e-12), data.angle.size
    low, high = _NARROWEST, 1.0
    for _ in range(_HALVINGS):
        share = float(np.sqrt(low * high))
        held = _fit(data, with_play=True, with_friction=with_friction, with_lag=with_lag, held=share)
        agrees = n * (held.rms**2 - least**2) < _UNLIKELY * noise**2
        low, high = (share, high) if agrees else (low, share)
    return high * float(np.ptp(data.angle))


def _fit(
    data: Branches, *, with_play: bool, with_friction: bool, with_lag: bool, held: float | None = None
) -> SeriesFit:
    """Fit one law.

    Parameters
    ----------
    held : the width as a share of the range of angles, where it is given.
    """
    low, high = float(data.angle.min()), float(data.angle.max())
    angle_unit, centre = max(0.5 * (high - low), 1e-12), 0.5 * (low + high)
    torque_unit = max(float(np.abs(data.torque).max()), 1e-12)
    unit = replace(data, angle=(data.angle - centre) / angle_unit, torque=data.torque / torque_unit)
    scaled = _Scaled(unit, angle_unit, torque_unit, with_play, with_friction, with_lag, held)
    source, whole = _source(scaled)
    lower, upper = source.unknowns.lower + 1e-9, source.unknowns.upper - 1e-9
    starts = np.clip(_starts(scaled)[:, whole.free], lower, upper)
    ends = [settle(source, start, None, no_progress) for start in _chosen(starts, source)]
    # a curve that ends at a limit of the search is no minimum: it counts where no other is found
    at_limit = [not _at_limit(source.unknowns, end.values).keys().isdisjoint(CURVE) for end in ends]
    best = ends[min(range(len(ends)), key=lambda k: (at_limit[k], source.misfit(ends[k].values)))]
    fit = _to_si(scaled, source.law_at(best.values), centre)
    return replace(fit, settled=best.last_step is None, at_limit=_at_limit(source.unknowns, best.values))


def _at_limit(unknowns: Unknowns, values: Floats) -> dict[str, tuple[bool, bool]]:
    """Return by name of `PARAMETERS` at which limits the search ended; a slope at one holds all of the curve."""
    found: dict[str, tuple[bool, bool]] = {}
    for name, value, low, high in zip(unknowns.names, values, unknowns.lower, unknowns.upper, strict=True):
        if value <= low or value >= high:
            found |= dict.fromkeys(_SETS.get(name, (name,)), (bool(value <= low), bool(value >= high)))
    first, between, last = values[-3:]
    if between <= _least_between(first, last) or not found.keys().isdisjoint(CURVE):
        found |= dict.fromkeys(CURVE, (True, True))
    return found


def _least_between(first: float, last: float) -> float:
    """Return the middle value of a slope below which it would fall between its ends, in Bernstein's basis."""
    return -float(np.sqrt(first * last))


@dataclass(frozen=True)
class _Whole:
    """Which of the ten numbers of a law are free, and the values of the others."""

    free: Integers
    held: Floats

    def __call__(self, values: Floats) -> Floats:
        every = self.held.copy()
        every[self.free] = values
        return every


def _source(scaled: _Scaled) -> tuple[BranchSource, _Whole]:
    """Return the rows of the numbers that are free; where a law does not depend on one it stays where it is."""
    lower, upper = _bounds(scaled)
    whole = _Whole(np.flatnonzero(lower < upper), lower)
    names = [SCALED[number] for number in whole.free.tolist()]
    nonlinear = np.ones(len(names), dtype=np.bool_)

    def slopes(values: Floats) -> Floats:
        v = whole(values)
        law = _law_of(scaled, v)
        by_law, curve = law.slopes(scaled.data.angle, scaled.data.up), np.array(law.curve)
        # middle, width and the three slopes set the curve: of three numbers differences cost nothing
        by_value = np.zeros((3, 10))
        for number in (0, 1, 7, 8, 9):
            step = np.zeros(10)
            step[number] = 1e-7 * max(abs(float(v[number])), 1e-2)
            by_value[:, number] = (np.array(_law_of(scaled, v + step).curve) - curve) / step[number]
        columns = by_law[:, 7:] @ by_value
        columns[:, :7] += by_law[:, :7]
        return np.asarray(columns[:, whole.free])

    unknowns = Unknowns.plain(names, lower[whole.free], upper[whole.free], nonlinear)
    return BranchSource(scaled.data, unknowns, lambda values: _law_of(scaled, whole(values)), slopes), whole


def _starts(scaled: _Scaled) -> Floats:
    """Return (k, 10) middle, width, log band, zero, friction, lag, drag, and Bernstein's three of the slope."""
    width = (None if scaled.held is None else 2.0 * scaled.held) if scaled.with_play else 0.0
    free = {"with_zero": scaled.with_play, "with_friction": scaled.with_friction}
    middle, play, zero, friction, drag, *slopes = play_starts(scaled.data, width, **free).T
    none = np.zeros_like(middle)
    return np.stack([middle, play, none + np.log(_FIRST_BAND), zero, friction, none, drag, *slopes], axis=1)


def _chosen(starts: Floats, source: BranchSource) -> Floats:
    """Return the best of starts (k, p), and the best of each class of widths, where these are free."""
    order = np.argsort([source.misfit(start) for start in starts], kind="stable")
    first = np.zeros(0, dtype=np.int64)
    if "width" in source.unknowns.names:
        widths = starts[order, source.unknowns.names.index("width")]
        _, first = np.unique(np.searchsorted(CLASSES, widths), return_index=True)
    return starts[order[np.union1d(np.arange(min(BEST_STARTS, len(order))), first)]]


def _bounds(scaled: _Scaled) -> tuple[Floats, Floats]:
    """Return the least and the largest values; equal where one is held."""
    lower = np.array([-1.0, 0.0, np.log(1e-3), -0.5, -0.9, -0.2, -0.3, 0.0, -_STEEPEST, 0.0])
    upper = np.array([1.0, 1.95, np.log(_WIDEST_BAND), 0.5, 0.9, 0.2, 0.9, _STEEPEST, _STEEPEST, _STEEPEST])
    if not scaled.with_play:
        lower[[1, 3]] = upper[[1, 3]] = 0.0
        lower[2] = upper[2] = np.log(_FIRST_BAND)
    if scaled.held is not None:
        lower[1] = upper[1] = 2.0 * scaled.held
    if not scaled.with_friction:
        lower[[4, 6]] = upper[[4, 6]] = 0.0
    if not scaled.with_lag:
        lower[5] = upper[5] = 0.0
    return lower, upper


def _law_of(scaled: _Scaled, v: Floats) -> TorqueAngleLaw:
    """Return the law in the data's own units."""
    middle, width, band, zero, friction, lag, drag, first, between, last = (float(value) for value in v)
    low = min(float(scaled.data.angle.min()) - middle + 0.5 * width, -1e-3)
    high = max(float(scaled.data.angle.max()) - middle - 0.5 * width, 1e-3)
    inner = max(between, _least_between(first, last))
    size = high - low
    rise, bend = 2.0 * (inner - first) / size, (first - 2.0 * inner + last) / size**2
    curve = (first - rise * low + bend * low * low, 0.5 * rise - bend * low, bend / 3.0)
    return TorqueAngleLaw(middle, max(width, 0.0), float(np.exp(band)), zero, friction, lag, curve, (low, high), drag)


def _to_si(scaled: _Scaled, law: TorqueAngleLaw, centre: float) -> SeriesFit:
    """Return the fit in rad and N·m, with the covariance of its parameters at that place."""
    a, t = scaled.angle_unit, scaled.torque_unit
    play, with_friction = scaled.with_play, scaled.with_friction
    free = np.array([True, play, play, play, with_friction, with_friction, True, True, True])
    up = scaled.data.up

    residual = law.torque_at(scaled.data.angle, up) - scaled.data.torque
    slopes = law.slopes(scaled.data.angle, up)
    slopes[:, 2] /= law.band
    lag = slopes[:, [5]] if scaled.with_lag else slopes[:, :0]
    jacobian = np.concatenate([np.delete(slopes, 5, axis=1)[:, free], lag], axis=1)
    dof = max(len(residual) - jacobian.shape[1], 1)
    size = np.linalg.norm(jacobian, axis=0)
    size = np.where(size > 0.0, size, 1.0)
    inverse = np.linalg.pinv(jacobian / size, rcond=1e-10) / size[:, None]
    # Noise of the angle counts on the steep flanks, noise of the torque in the play: each bin's own misfit weighs it.
    spread = inverse * residual
    whole = spread @ spread.T * (len(residual) / dof)
    covariance = np.zeros((9, 9))
    chosen = np.flatnonzero(free)
    covariance[np.ix_(chosen, chosen)] = whole[: len(chosen), : len(chosen)]
    units = np.array([a, a, t, t, t, 1.0, t / a, t / a**2, t / a**3])
    covariance *= units[:, None] * units
    p = law.curve
    real = TorqueAngleLaw(
        centre + a * law.middle, a * law.width, t * law.band, t * law.zero, t * law.friction, a * law.lag,
        (t / a * p[0], t / a**2 * p[1], t / a**3 * p[2]), (a * law.reach[0], a * law.reach[1]), law.drag,
    )  # fmt: skip
    return SeriesFit(real, covariance, t * float(np.sqrt(np.mean(residual**2))), dof, scaled.with_play)

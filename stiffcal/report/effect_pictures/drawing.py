"""What each effect does to a load-deformation curve, computed by the effect's own law on a lever with two joints.

The example: two parallel joints, links of one metre and of 0.8 m, a force at the tool that goes up and down along one
line, twice, against the other direction too. The effect is enlarged until it is visible; the model without it is
joint compliance alone.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from stiffcal.arrays import Floats
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.measurements.load_states import Attachment, MeasurementSetup
from stiffcal.mechanics.chain import BeamFrame, Chain
from stiffcal.model.assembled.composite import CompliantRobot, PlacedEffect
from stiffcal.model.balance.equilibrium import NoBalanceError, solve_balance
from stiffcal.model.balance.stated_spring import parallel_spring
from stiffcal.model.catalogue.catalogue import find_effects
from stiffcal.model.catalogue.plugin_code import PluginCode
from stiffcal.model.effect import Effect, EffectAtRest, NodeLoads, Observed, ParameterRole, Place, StateOrder
from stiffcal.quantity import LENGTH
from stiffcal.report.content import EffectPicture
from stiffcal.report.effect_pictures.clamped import clamped_picture
from stiffcal.report.effect_pictures.motion import torque_picture
from stiffcal.report.effect_pictures.sketch import sketch
from stiffcal.report.effect_pictures.weight import weight_picture
from stiffcal.trust.output_kinds import EFFECT_PICTURE
from stiffcal.trust.outputs import check_output, written

FIRST, SECOND = 1.0, 0.8
# Joint stiffness 5e5 N·m/rad: a medium-size robot's main axes (Wang, Zhang and Fuhlbrigge 2009, section III.C).
COMPLIANCE = 2e-6
LARGEST_FORCE = 400.0
# The effect is drawn as large as this share of the largest deflection.
DRAWN_SIZE = 0.4
# What is smaller than this share of the deflection at a thousand times its usual size does not show.
SHOWS = 1e-3
MOST_ENLARGED = 1e3
# Across the lever nothing gives but what the effect adds: its size is then measured by this, m.
LEAST_WHOLE = 2e-3
# Another line of force is shown only where the effect stands out that much more.
CLEARLY = 2.0
# A balancing spring from behind the base to the first link.
SPRING: dict[str, object] = {"joint": 1, "anchor_m": [-0.6, 0.2, 0.0], "arm_m": [0.3, 0.0, 0.0], "rate_N_m": None}
LINES = ((0.0, 1.0, 0.0), (0.0, 0.0, 1.0), (0.6, 0.8, 0.0))
AXES = "xyz"


@dataclass(frozen=True)
class LeverExample:
    """Loads on the lever."""

    angles: Floats
    """(n, 2) rad, of the lever's joints."""
    wrench: Floats
    """(n, 6) N and N·m, base axes at the tool."""
    order: StateOrder
    """Times and memory of the states."""
    line: Floats
    """Unit vector of the force."""
    x: Floats
    """(n,) abscissa of the curve."""
    x_label: str
    """What ``x`` is, with its unit."""
    unloading: NDArray[np.bool_]
    """(n,) True while the load decreases."""


def lever() -> tuple[Chain, MeasurementSetup]:
    """Return the example's robot, and where force and target sit on it."""
    fixed = np.tile(np.eye(4), (2, 1, 1))
    fixed[1, 0, 3] = FIRST
    flange, end = np.eye(4), np.eye(4)
    flange[0, 3], end[0, 3] = SECOND, FIRST
    chain = Chain(
        name="lever", joint_names=("A1", "A2"), fixed=fixed, flange=flange, coupling=np.eye(2), offset=np.zeros(2),
        limits=np.tile([-np.inf, np.inf], (2, 1)), gear_ratio=np.ones(2), gear_orders=((), ()),
        mechanical=np.zeros(2, dtype=np.bool_), bearing=np.zeros(2), link_names=("link", "arm"),
        link_mass=np.zeros(2), link_com=np.zeros((2, 3)), masses_known=True, gravity=np.zeros(3),
        beams={"link": BeamFrame(1, end, FIRST)}, compensator=SPRING,
    )  # fmt: skip
    tool = Attachment(3, np.eye(4))
    offset_frame = np.eye(4)
    offset_frame[1, 3] = 0.15
    return chain, MeasurementSetup(
        wrench_axes=Attachment(0, np.eye(4)), wrench_point=tool, targets=(Attachment(3, offset_frame),),
        target_names=("target",), moments_measured=True,
    )  # fmt: skip


def effect_picture(effect: Effect) -> EffectPicture | None:
    """Return the picture of an effect on the example where it does most; None where it never shows.

    Parameters
    ----------
    effect : of the catalogue, or the user's own.

    Examples
    --------
    >>> from stiffcal.model.catalogue.catalogue import find_effects
    >>> picture = effect_picture(find_effects()["backlash"])
    >>> picture.x_label, picture.y_label
    ('force along y [N]', 'deflection along y [mm]')
    """
    chain, setup = lever()
    if not isinstance(effect, EffectAtRest):
        return torque_picture(effect, chain)
    places = effect.places(chain)
    best: tuple[float, EffectPicture] | None = None
    for example in _examples(effect, places, chain):
        for place in places[:2]:
            for sensed in (setup, replace(setup, moments_measured=False)):
                candidate = _enlarged_picture(effect, place, chain, sensed, example)
                if candidate is not None and (best is None or candidate[0] > CLEARLY * best[0]):
                    best = candidate
    if best is not None:
        return best[1]
    return (
        _late_clock_picture(effect, chain, setup)
        or _torque_next_to(effect, places, chain)
        or weight_picture(effect, chain, setup, _caption(effect))
        or _clamped_picture(effect, places)
    )


def draw_effect(name: str, file: Path, plugins: PluginCode | None = None, *, overwrite: bool = False) -> str:
    """Write an effect's picture, and return its caption.

    Raises
    ------
    InputError : the effect does not exist or does not show, or the file cannot be written or holds something else.
    """
    from stiffcal.report.figures.canvas import save_figure
    from stiffcal.report.figures.effect_picture import draw_effect_picture

    check_output(file, EFFECT_PICTURE, overwrite)
    picture = _picture_of(name, plugins)
    if picture is None:
        mend = f"leave -o out: stiffcal effects {name} explains where it acts"
        raise InputError.at(FaultCode.DATA_MISSING, "command line", "-o", f"{name} has no load-deformation curve", mend)
    with written(file, EFFECT_PICTURE, overwrite) as temporary:
        save_figure(draw_effect_picture(picture), temporary)
    return picture.caption


def sketch_effect(name: str, plugins: PluginCode | None = None) -> list[str]:
    """Return an effect's picture in letters, line by line; empty where it never shows."""
    picture = _picture_of(name, plugins)
    return [] if picture is None else sketch(picture)


def _picture_of(name: str, plugins: PluginCode | None) -> EffectPicture | None:
    """Return an effect's picture; None where it never shows, or where a law of the user's needs more than a lever."""
    effect = find_effects(plugins)[name]
    try:
        return effect_picture(effect)
    except (IndexError, KeyError):
        if name in find_effects():
            raise
        return None


def _examples(effect: EffectAtRest, places: Sequence[Place], chain: Chain) -> Iterator[LeverExample]:
    """Return load cycles along each line; for effects that follow a joint's angle, poses under one load."""
    if not places:
        return
    # Without load, what differs between two poses follows the joints' own angles.
    probe = NodeLoads(np.zeros((6, 6, 2)), np.array([[0.0, 1.0], [0.0, 1.0]]), _order(2))
    covariate = effect.covariate(places[0], chain, probe)
    by_angle = covariate is not None and covariate.unit == "rad" and bool(np.ptp(covariate.value) > 0.0)
    for line in LINES:
        yield _poses(np.array(line)) if by_angle else _cycles(np.array(line))


def _cycles(line: Floats) -> LeverExample:
    """Return the force up and down along a line, then against it, twice over."""
    up = np.linspace(0.0, 1.0, 21)
    cycle = np.concatenate([up, up[-2::-1], -up[1:], -up[-2::-1]])
    level = np.concatenate([cycle, cycle[1:]])
    order = _order(len(level), level)
    wrench = np.zeros((len(level), 6))
    wrench[:, :3] = LARGEST_FORCE * level[:, None] * line
    unloading = np.abs(level) < np.abs(np.concatenate([[0.0], level[:-1]]))
    angles = np.tile(np.radians([20.0, -35.0]), (len(level), 1))
    return LeverExample(
        angles, wrench, order, line, LARGEST_FORCE * level, f"force along {_line_words(line)} [N]", unloading
    )


def _poses(line: Floats) -> LeverExample:
    """Return one load in poses all through the joints' turn."""
    angle = np.linspace(-np.pi, np.pi, 73)
    wrench = np.zeros((len(angle), 6))
    wrench[:, :3] = LARGEST_FORCE * line
    joints = np.stack([angle, np.full_like(angle, np.pi / 5.0)], axis=1)
    order = replace(_order(len(angle)), run=np.arange(len(angle), dtype=np.int64))
    label = f"angle of joint 1 [°], under {LARGEST_FORCE:.0f} N along {_line_words(line)}"
    return LeverExample(joints, wrench, order, line, np.degrees(angle), label, np.zeros(len(angle), dtype=np.bool_))


def _line_words(line: Floats) -> str:
    return AXES[int(np.argmax(np.abs(line)))] if np.abs(line).max() > 0.99 else "a slant in the plane"


def _order(n: int, level: Floats | None = None) -> StateOrder:
    """Return an order: a state a minute, held half of it, the room warming by three degrees, motors giving a little."""
    time = 60.0 * np.arange(n, dtype=np.float64)
    motor = np.zeros((2, n)) if level is None else 5e-4 * np.stack([level, level])
    return StateOrder(
        run=np.zeros(n, dtype=np.int64), time=time, hold=np.full(n, 30.0), motor=motor,
        temperature=3.0 * np.arange(n) / max(n - 1, 1), since_reference=time, number=np.arange(1, n + 1),
    )  # fmt: skip


def _enlarged_picture(
    effect: EffectAtRest, place: Place, chain: Chain, setup: MeasurementSetup, example: LeverExample
) -> tuple[float, EffectPicture] | None:
    """Return how much of the effect shows at its usual size, and the picture with it enlarged."""
    springs = _springs()
    plain = CompliantRobot(chain, springs)
    usual = _usual(effect, place, plain, setup, example)
    if usual is None:
        return None
    # An effect that holds the joint's compliance stands in its place.
    included = effect.includes + ((effect.name,) if effect.name == "joint-compliance" else ())
    effects = tuple(
        placed_effect
        for placed_effect in springs
        if not (placed_effect.effect.name in included and placed_effect.place == place)
    )
    try:
        without = _deflection(
            plain if effect.name != "joint-compliance" else replace(plain, placed=effects), setup, example
        )
        largest = max(float(np.abs(_deflection(plain, setup, example)).max()), LEAST_WHOLE)
        factor, with_it = 1.0, without
        # What holds the joint's own compliance is never drawn stiffer than this.
        least = 1.0 if effect.includes else 1e-3
        for _ in range(3):
            robot = replace(plain, placed=(*effects, _scaled(effect, place, usual, factor)))
            with_it = _deflection(robot, setup, example)
            change = float(np.abs(with_it - without).max())
            if factor == 1.0:
                visible = change
            if change <= SHOWS * largest / MOST_ENLARGED:
                return None
            factor = float(np.clip(factor * DRAWN_SIZE * largest / change, least, MOST_ENLARGED))
    except NoBalanceError:
        return None
    difference = np.abs(with_it - without).max(axis=0)
    if difference.max() < SHOWS * largest:
        return None
    axis = int(np.argmax(difference))
    return visible / largest, _as_picture(effect, example, axis, without[:, axis], with_it[:, axis])


def _as_picture(effect: Effect, example: LeverExample, axis: int, without: Floats, with_it: Floats) -> EffectPicture:
    """Return the picture; where all cycles run on one curve, that curve once."""
    x, unloading = example.x, example.unloading
    abscissae, index_of_state = np.unique(x, return_inverse=True)
    high, low = np.full(len(abscissae), -np.inf), np.full(len(abscissae), np.inf)
    np.maximum.at(high, index_of_state, with_it)
    np.minimum.at(low, index_of_state, with_it)
    if float((high - low).max()) < 0.02 * float(np.ptp(with_it)):
        _, first = np.unique(x, return_index=True)
        x, without, with_it, unloading = x[first], without[first], with_it[first], np.zeros(len(first), dtype=np.bool_)
    unit = LENGTH.usual
    label = unit.in_brackets(f"deflection along {AXES[axis]}")
    y, y_with = unit.factor * without, unit.factor * with_it
    return EffectPicture(effect.name, example.x_label, label, x, y, y_with, unloading, _caption(effect))


def _caption(effect: Effect) -> str:
    text = (effect.fingerprint or effect.summary).rstrip(".")
    return f"Effect of {effect.name} on a lever with two joints, exaggerated: {text}."


def _late_clock_picture(effect: Effect, chain: Chain, setup: MeasurementSetup) -> EffectPicture | None:
    """Return the picture of a log that runs behind the force while the load moves."""
    measured_at = getattr(effect, "measured_at", None)
    if measured_at is None:
        return None
    example = _cycles(np.array(LINES[0]))
    true = _deflection(CompliantRobot(chain, _springs()), setup, example)[:, 1] * LENGTH.usual.factor
    # One full cycle a second: a sweep, not holds.
    time = np.linspace(0.0, 2.0, len(true))
    late = np.asarray(measured_at(time, true, -0.05), dtype=np.float64)
    label = LENGTH.usual.in_brackets("deflection along y")
    return EffectPicture(
        effect.name, example.x_label, label, example.x, true, late, example.unloading, _caption(effect)
    )


def _torque_next_to(effect: Effect, places: Sequence[Place], chain: Chain) -> EffectPicture | None:
    """Return the torque that acts in parallel to a drive, over the joint's angle."""
    values = {spec.symbol: spec.typical for spec in effect.parameters}
    angle = np.linspace(-np.pi, np.pi, 73)
    for place in places[:1]:
        spring = parallel_spring(chain, PlacedEffect(effect, place, values))
        if spring is not None:
            return EffectPicture(
                effect.name, "angle of joint 1 [°]", "additional torque on the joint [N·m]", np.degrees(angle),
                np.zeros_like(angle), spring.torque(angle), np.zeros(len(angle), dtype=np.bool_), _caption(effect),
            )  # fmt: skip
    return None


def _clamped_picture(effect: Effect, places: Sequence[Place]) -> EffectPicture | None:
    """Return what shows in a clamped motor's angle alone."""
    example = _cycles(np.array(LINES[0]))
    level = example.x / LARGEST_FORCE
    return clamped_picture(effect, places[0], example.order, level, example.unloading) if places else None


def _springs() -> tuple[PlacedEffect, ...]:
    effect = find_effects()["joint-compliance"]
    return tuple(PlacedEffect(effect, Place("joints", (joint,)), {"c": COMPLIANCE}) for joint in (1, 2))


def _usual(
    effect: EffectAtRest, place: Place, robot: CompliantRobot, setup: MeasurementSetup, example: LeverExample
) -> dict[str, float] | None:
    """Return values of usual size, shapes from the middle of the effect's grid; None where no shape shows."""
    values = {spec.symbol: spec.typical for spec in effect.parameters}
    balance = solve_balance(robot, example.angles, example.wrench, setup, example.order)
    wrench = np.zeros((6, 6, len(example.x)))
    wrench[1, 5], wrench[3, 5] = balance.joint_torque[:, 0], balance.joint_torque[:, 1]
    grid = effect.nonlinear_grid(place, robot.chain, NodeLoads(wrench, example.angles.T, example.order))
    for symbol, values_of_symbol in grid.items():
        if not len(values_of_symbol):
            return None
        values[symbol] = float(values_of_symbol[len(values_of_symbol) // 2])
    return values


def _scaled(effect: Effect, place: Place, usual: dict[str, float], factor: float) -> PlacedEffect:
    """Return the effect with its amplitudes enlarged, within their bounds."""
    values = dict(usual)
    for spec in effect.parameters:
        if spec.role is not ParameterRole.NONLINEAR:
            values[spec.symbol] = spec.value_of(spec.amplitude_of(usual[spec.symbol]) * factor)
    return PlacedEffect(effect, place, values)


def _deflection(robot: CompliantRobot, setup: MeasurementSetup, example: LeverExample) -> Floats:
    """Return (n, 3) m, the target's displacement as the tracker measures it."""
    balance = solve_balance(robot, example.angles, example.wrench, setup, example.order)
    displacement = np.ascontiguousarray(np.moveaxis(balance.displacement, 0, -1))
    observed = Observed(displacement, example.order)
    observed_shift = displacement.copy()
    for placed_effect in robot.placed:
        shift = placed_effect.observation_shift(observed)
        if shift is not None:
            observed_shift = observed_shift + shift
    return np.asarray(observed_shift[0, :3].T)

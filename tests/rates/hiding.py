"""What is hidden: effects at random places with random ratios of their parameters, before they are sized."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.identification.fitting.regressors import Linearised
from stiffcal.mechanics.rotations import rotation_from_vector
from stiffcal.model.assembled.composite import CompliantRobot, PlacedEffect
from stiffcal.model.balance.equilibrium import NoBalanceError
from stiffcal.model.catalogue.catalogue import built_in_effects
from stiffcal.model.effect import Effect, ParameterRole, Place
from stiffcal.model.laws.drives import drive_torque
from tests.rates.outside import OUTSIDE

Values = dict[str, float]
Draw = Callable[[np.random.Generator, PlacedEffect, Linearised], Values | None]

# The issue sizes them at 0.5 to 1.5 times the noise, as they are in life.
FAINT = (
    "thermal-drift",
    "tracker-frame",
    "wrench-frame",
    "target-offset",
    "load-point-offset",
    "wrench-scale",
    "wrench-origin",
)


def _signed(rng: np.random.Generator) -> float:
    return float(rng.choice([-1.0, 1.0]) * rng.uniform(0.4, 1.0))


def _some(rng: np.random.Generator, symbols: tuple[str, ...], signed: bool = False) -> Values:
    """Return random sizes of one or more of the symbols."""
    count = int(rng.integers(1, len(symbols) + 1))
    picked = rng.choice(len(symbols), size=count, replace=False)
    return {symbols[k]: _signed(rng) if signed else float(rng.uniform(0.4, 1.0)) for k in sorted(picked)}


def _torque(one: PlacedEffect, state: Linearised) -> Floats:
    return np.asarray(drive_torque(state.robot.chain, state.loads.wrench, one.place.joints[0]))


def _crosses_zero(torque: Floats, share: float) -> bool:
    positive = float(np.mean(torque > 0.0))
    return share < positive < 1.0 - share


def _tilt(rng: np.random.Generator, one: PlacedEffect, state: Linearised) -> Values | None:
    return _some(rng, ("x", "y"))


def _translation(rng: np.random.Generator, one: PlacedEffect, state: Linearised) -> Values | None:
    return _some(rng, ("tx", "ty", "tz"))


def _beam(rng: np.random.Generator, one: PlacedEffect, state: Linearised) -> Values | None:
    rigidity = 1e7
    return {
        "EI2": rigidity * rng.uniform(1.0, 2.0),
        "EI3": rigidity * rng.uniform(0.7, 1.5),
        "GJ": rigidity * rng.uniform(0.6, 1.2),
        "EA": 1e3 * rigidity,
    }


def _springs(rng: np.random.Generator, one: PlacedEffect, state: Linearised) -> Values | None:
    return {symbol: 1e7 * rng.uniform(0.6, 1.6) for symbol in ("k1", "k2", "k3")}


def _base(rng: np.random.Generator, one: PlacedEffect, state: Linearised) -> Values | None:
    return _some(rng, ("rx", "ry"))


def _tool(rng: np.random.Generator, one: PlacedEffect, state: Linearised) -> Values | None:
    return _some(rng, ("rx", "ry"))


def _coupling(rng: np.random.Generator, one: PlacedEffect, state: Linearised) -> Values | None:
    return {"c": _signed(rng)}


def _cubic(rng: np.random.Generator, one: PlacedEffect, state: Linearised) -> Values | None:
    reach = float(np.abs(_torque(one, state)).max())
    values = {"c3": rng.uniform(0.4, 1.0) / reach**3}
    if rng.uniform() < 0.3:
        values["c2"] = _signed(rng) / reach**2
    return values


def _two_slope(rng: np.random.Generator, one: PlacedEffect, state: Linearised) -> Values | None:
    size = np.abs(_torque(one, state))
    return {"c": 1.0, "knee": float(np.quantile(size, rng.uniform(0.25, 0.6)))}


def _asymmetric(rng: np.random.Generator, one: PlacedEffect, state: Linearised) -> Values | None:
    return {"c": 1.0} if _crosses_zero(_torque(one, state), 0.15) else None


def _backlash(rng: np.random.Generator, one: PlacedEffect, state: Linearised) -> Values | None:
    torque = _torque(one, state)
    if not _crosses_zero(torque, 0.1):
        return None
    return {"width": 1.0, "band": float(rng.uniform(0.005, 0.03) * np.abs(torque).max())}


def _hysteresis(rng: np.random.Generator, one: PlacedEffect, state: Linearised) -> Values | None:
    torque, run = _torque(one, state), state.data.run
    swing = max(float(np.ptp(torque[run == number])) for number in np.unique(run))
    return {"c": 1.0, "slip": float(rng.uniform(0.06, 0.25) * swing)}


def _periodic(rng: np.random.Generator, one: PlacedEffect, state: Linearised) -> Values | None:
    phase = rng.uniform(0.0, 2.0 * np.pi)
    return {"order": float(rng.integers(1, 5)), "a": float(np.cos(phase)), "b": float(np.sin(phase))}


def _creep(rng: np.random.Generator, one: PlacedEffect, state: Linearised) -> Values | None:
    return {"c": 1.0, "time": float(rng.uniform(8.0, 80.0))}


def _drift(rng: np.random.Generator, one: PlacedEffect, state: Linearised) -> Values | None:
    return {symbol: _signed(rng) for symbol in ("x", "y", "z")}


def _turned(rng: np.random.Generator, one: PlacedEffect, state: Linearised) -> Values | None:
    return {symbol: _signed(rng) for symbol in ("rx", "ry", "rz")}


def _load_point(rng: np.random.Generator, one: PlacedEffect, state: Linearised) -> Values | None:
    return _drift(rng, one, state) if not state.data.setup.moments_measured else None


def _sensor_point(rng: np.random.Generator, one: PlacedEffect, state: Linearised) -> Values | None:
    return _drift(rng, one, state) if state.data.setup.moments_measured else None


def _gain(rng: np.random.Generator, one: PlacedEffect, state: Linearised) -> Values | None:
    return {"moment": 1.0 + 0.05 * _signed(rng)} if state.data.setup.moments_measured else None


def _compensator(rng: np.random.Generator, one: PlacedEffect, state: Linearised) -> Values | None:
    return {"rate": 1.0}


def _seat(rng: np.random.Generator, one: PlacedEffect, state: Linearised) -> Values | None:
    number = int(rng.choice(state.data.index)) + 1
    return {"state": float(number), "x": _signed(rng), "y": _signed(rng), "z": _signed(rng)}


INSIDE: Mapping[str, Draw] = {
    "bearing-tilt": _tilt,
    "joint-translation": _translation,
    "link-beam": _beam,
    "link-springs": _springs,
    "base-compliance": _base,
    "tool-compliance": _tool,
    "axis-coupling": _coupling,
    "cubic-stiffness": _cubic,
    "two-slope": _two_slope,
    "asymmetric-stiffness": _asymmetric,
    "backlash": _backlash,
    "friction-hysteresis": _hysteresis,
    "periodic-stiffness": _periodic,
    "creep": _creep,
    "thermal-drift": _drift,
    "tracker-frame": _turned,
    "wrench-frame": _turned,
    "target-offset": _drift,
    "load-point-offset": _load_point,
    "gravity-compensator": _compensator,
}
SEAT: Mapping[str, Draw] = {"seat-shift": _seat}
# Drawn by name only: the classes keep the draws that earlier rates were taken with.
SENSOR: Mapping[str, Draw] = {"wrench-origin": _sensor_point, "wrench-scale": _gain}

# Laws of the whole torque, or of where it starts: who does not know the weights does not know it.
OF_TOTAL_TORQUE = ("cubic-stiffness", "two-slope", "asymmetric-stiffness", "backlash", "friction-hysteresis")


def draw_inside(
    rng: np.random.Generator, state: Linearised, names: Mapping[str, Draw] = INSIDE, only: str = ""
) -> PlacedEffect:
    """Draw an effect of the catalogue, a place and ratios of its parameters, sizes still open."""
    catalogue = built_in_effects()
    pool = [only] if only else list(names)
    while True:
        name = pool[int(rng.integers(len(pool)))]
        places = catalogue[name].places(state.robot.chain)
        if not places:
            if only:
                raise NoBalanceError(f"{only} has no place on this robot")
            continue
        place = places[int(rng.integers(len(places)))]
        effect = catalogue[name].at(place, state.robot.chain)
        values = {**names, **SENSOR}[name](rng, PlacedEffect(effect, place), state)
        # across a prismatic axis an effect has fewer parameters
        symbols = {spec.symbol for spec in effect.parameters}
        values = {symbol: value for symbol, value in (values or {}).items() if symbol in symbols}
        if values:
            return PlacedEffect(effect, place, values)


def draw_outside(rng: np.random.Generator, state: Linearised) -> PlacedEffect:
    """Draw an effect that the catalogue does not hold."""
    effect: Effect = OUTSIDE[int(rng.integers(len(OUTSIDE)))]
    places = effect.places(state.robot.chain)
    place = places[int(rng.integers(len(places)))]
    if place.kind == "pairs" and rng.uniform() < 0.5:
        place = Place("pairs", (place.joints[1], place.joints[0]))
    values: Values = {"c": 1.0}
    if effect.name == "cross-stiffness":
        values |= {"order": float(rng.choice([1.6, 2.3, 2.7, 3.4])), "phase": float(rng.uniform(0.0, 2.0 * np.pi))}
    if effect.name == "loose-beyond":
        angle = state.data.angles[place.joints[0] - 1]
        values["angle"] = float(np.quantile(angle, rng.uniform(0.35, 0.65)))
    if effect.name == "wander":
        values["seed"] = float(rng.integers(1 << 30))
    return PlacedEffect(effect, place, values)


def shift_of_places(hidden: Sequence[PlacedEffect], places: Floats, flange: Floats) -> Floats:
    """Return (n, 3) by how much what is wrong with the set-up moves the places that the tracker measures.

    Parameters
    ----------
    hidden : all that is hidden.
    places : (n, 3) m, where the target is.
    flange : (n, 3, 3) base_from_flange.
    """
    shift = np.zeros_like(places)
    for one in hidden:
        if one.effect.name == "target-offset":
            shift += flange @ np.array([one.values.get(axis, 0.0) for axis in "xyz"])
        if one.effect.name == "tracker-frame":
            turn = rotation_from_vector(np.array([one.values.get(axis, 0.0) for axis in ("rx", "ry", "rz")]))
            shift += places @ (turn - np.eye(3)).T
    return shift


def scaled(one: PlacedEffect, factor: float) -> PlacedEffect:
    """Return the effect with its amplitudes multiplied (rigidities divided); shapes stay."""
    values = {}
    for symbol, value in one.values.items():
        spec = one.effect.spec(symbol)
        if spec.role is ParameterRole.NONLINEAR:
            values[symbol] = value
        else:
            values[symbol] = spec.value_of(factor * spec.amplitude_of(value))
    return PlacedEffect(one.effect, one.place, values)


def with_effects(robot: CompliantRobot, *more: PlacedEffect) -> CompliantRobot:
    """Return the robot with effects added."""
    return CompliantRobot(robot.chain, (*robot.placed, *more), robot.deformed)

"""What every effect of the catalogue promises, plugins included: found by walking, never by name."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from stiffcal.arrays import Floats
from stiffcal.estimation.unknowns import free_columns
from stiffcal.identification.derivatives.observation import Observations, evaluate, observe
from stiffcal.identification.noise.weights import predict_observations
from stiffcal.mechanics.chain import Chain
from stiffcal.model.assembled.composite import CompliantRobot, PlacedEffect
from stiffcal.model.balance.deformed_chain import deformed_chain, node_wrenches
from stiffcal.model.balance.equilibrium import rest_under_weight
from stiffcal.model.balance.stated_spring import parallel_spring
from stiffcal.model.catalogue.catalogue import built_in_effects
from stiffcal.model.effect import Effect, EffectAtRest, Inputs, NodeLoads, Observed, ParameterRole, ParameterSpec, Place
from tests.laboratory.effect_bench import bare_states, robot_chain
from tests.laboratory.robots import SIX_STIFFNESS, force_sensor_setup, six_axis_joints

EFFECTS = built_in_effects()
ROOT = Path(__file__).resolve().parents[2]

# Interface, section 3: the names are fixed.
NAMES = {
    "joint-compliance", "bearing-tilt", "joint-translation", "joint-full", "axis-coupling", "link-beam", "link-springs",
    "base-compliance", "tool-compliance", "cubic-stiffness", "two-slope", "asymmetric-stiffness", "backlash",
    "friction-hysteresis", "periodic-stiffness", "gravity-compensator", "servo-deflection", "creep", "thermal-drift",
    "seat-shift", "tracker-frame", "wrench-frame", "target-offset", "load-point-offset", "wrench-bias", "clock-offset",
    "joint-friction", "stribeck", "friction-load", "friction-temperature", "torque-ripple", "viscous-power",
    "friction-asymmetry", "presliding", "fixture-compliance", "encoder-drift", "wrench-origin", "wrench-scale",
    "link-geometry", "joint-offset", "joint-eccentricity", "link-weight",
}  # fmt: skip
# Physics, section 2: the symbols are fixed.
SYMBOLS = {
    "joint-compliance": "c", "bearing-tilt": "x y", "joint-translation": "tx ty tz", "axis-coupling": "c",
    "link-beam": "EI2 EI3 GJ EA", "link-springs": "k1 k2 k3", "base-compliance": "rx ry rz tx ty tz",
    "tool-compliance": "rx ry rz tx ty tz", "cubic-stiffness": "c2 c3", "two-slope": "c knee",
    "asymmetric-stiffness": "c", "backlash": "width band", "friction-hysteresis": "c slip",
    "periodic-stiffness": "a b order", "gravity-compensator": "rate", "servo-deflection": "", "creep": "c time",
    "thermal-drift": "x y z rx ry rz", "seat-shift": "state x y z", "tracker-frame": "rx ry rz",
    "wrench-frame": "rx ry rz", "target-offset": "x y z", "load-point-offset": "x y z",
    "wrench-bias": "fx fy fz mx my mz mass", "clock-offset": "offset",
    "joint-friction": "coulomb viscous",
    "stribeck": "stribeck velocity exponent", "friction-load": "per_Nm", "friction-temperature": "coulomb_K viscous_K",
    "torque-ripple": "a b order", "viscous-power": "factor power", "friction-asymmetry": "offset",
    "presliding": "stiffness angle", "fixture-compliance": "translation rotation", "encoder-drift": "rad_per_s",
    "wrench-origin": "x y z", "wrench-scale": "moment force",
    "link-geometry": "x y rx ry", "joint-offset": "zero", "joint-eccentricity": "a b order", "link-weight": "mx my",
}  # fmt: skip
# First-order columns leave out that a law's own share moves the load point, and that the drives give under the torques
# so changed: force × lever × compliance of the softest joint, 400 N × 1 m × 6e-5 rad/(N·m) at the wrist = 2.4 %.
COLUMN_TOLERANCE = 0.025


@cache
def chain() -> Chain:
    """Return a robot on which every effect has a place."""
    geometry: dict[str, object] = {
        "joint": 2, "anchor_m": [0.05, 0.1, 0.15], "arm_m": [0.12, -0.35, 0.08], "rate_N_m": 1e5, "preload_N": 2000.0,
    }  # fmt: skip
    return replace(robot_chain(), compensator=geometry)


def measures_moments(effect: Effect) -> bool:
    """True but for the effect that needs a force-only set-up."""
    return not isinstance(effect, EffectAtRest) or "moments" not in (effect.lacking(chain(), bare_states([0])) or "")


@cache
def observations(moments: bool) -> Observations:
    """Return four poses, three cycles of load each, with times and drives that are pushed off a little."""
    rng = np.random.default_rng(21)
    load = np.tile([0.0, 0.5, 1.0, 0.4, -0.6, -1.0, -0.3, 0.2], 3)
    run = np.repeat(np.arange(4), len(load))
    direction = rng.normal(size=(4, 6)) * np.repeat([250.0, 40.0], 3)
    wrench = np.tile(load, 4)[:, None] * direction[run]
    wrench += rng.normal(size=wrench.shape) * np.repeat([30.0, 5.0], 3)
    setup = replace(force_sensor_setup(chain()), moments_measured=moments)
    if not moments:
        wrench[:, 3:] = 0.0
    joints = six_axis_joints(rng, 4)[run] + 1e-6 * rng.normal(size=(len(run), 6))
    n = len(run)
    stamps, upright = np.arange(0.0, 8.0 * n, 8.0), np.tile(np.eye(3), (n, 1, 1, 1))
    states = bare_states(run.tolist(), joints, setup, wrench=wrench, time=stamps, rotation=upright)
    return observe(states, chain())


@cache
def node_loads(moments: bool) -> NodeLoads:
    """Return what the nodes carry on the rigid chain in these states."""
    data = observations(moments)
    inputs = Inputs(data.angles, data.wrench, data.setup)
    rigid = CompliantRobot(chain(), ())
    unloaded = rest_under_weight(rigid, inputs)
    wrench = node_wrenches(chain(), deformed_chain(chain(), data.angles, None), inputs)
    return NodeLoads(wrench, data.angles, data.order, unloaded.wrench)


def placed(effect: Effect, place: Place) -> CompliantRobot:
    """Return drives on all joints and the effect next to them, at typical values; shapes from the data's grid."""
    drive = EFFECTS["joint-compliance"]
    drives = tuple(
        PlacedEffect(drive, Place("joints", (k + 1,)), {"c": 1.0 / float(SIX_STIFFNESS[k])})
        for k in range(6)
        if not (effect.name == drive.name or drive.name in effect.includes) or (k + 1) not in place.joints
    )
    values = {spec.symbol: spec.typical for spec in effect.parameters}
    grids = {}
    if isinstance(effect, EffectAtRest):
        grids = effect.nonlinear_grid(place, chain(), node_loads(measures_moments(effect)))
    for symbol, grid in grids.items():
        if len(grid):
            values[symbol] = float(grid[len(grid) // 2])
    return CompliantRobot(chain(), (*drives, PlacedEffect(effect, place, values)))


@pytest.fixture(params=sorted(EFFECTS))
def effect(request: pytest.FixtureRequest) -> Effect:
    """Every effect of the catalogue in turn."""
    return EFFECTS[request.param]


def test_names_are_those_of_the_interface() -> None:
    assert set(EFFECTS) >= NAMES


def test_symbols_are_those_of_the_physics(effect: Effect) -> None:
    symbols = [spec.symbol for spec in effect.parameters]
    assert len(symbols) == len(set(symbols))
    if effect.name in SYMBOLS:
        assert symbols == SYMBOLS[effect.name].split()
    elif effect.name == "joint-full":
        assert symbols == [f"c{i}{j}" for i in range(1, 7) for j in range(i, 7)]


def test_file_is_named_as_the_effect_and_has_a_twin(effect: Effect) -> None:
    stem = effect.name.replace("-", "_")
    assert type(effect).__module__ == f"stiffcal.effects.{stem}"
    twin = ROOT / "tests" / "effects" / f"test_{stem}.py"
    assert "def test_" in twin.read_text("utf-8")


def test_a_page_to_read(effect: Effect) -> None:
    text = effect.describe()
    paragraphs = text.split("\n\n")
    assert paragraphs[0].endswith(".")
    assert "Law" in text
    assert "Assumes" in text
    assert "Limits" in text
    for words in (effect.summary, effect.fingerprint, effect.how_to_check):
        assert len(words) > 20
    assert effect.summary[-1] != "."
    assert effect.how_to_check[-1] in ".?"


def test_numbers_have_units_bounds_and_sources(effect: Effect) -> None:
    for spec in effect.parameters:
        assert spec.unit, spec.symbol
        assert len(spec.meaning) > 8, spec.symbol
        assert len(spec.source) > 20, spec.symbol
        assert spec.lower < spec.upper, spec.symbol
        assert spec.lower <= spec.typical <= spec.upper, spec.symbol
        assert spec.typical != 0.0, spec.symbol
        if spec.role is ParameterRole.SETUP:
            assert spec.lower <= spec.neutral <= spec.upper, spec.symbol
        if spec.inverse:
            assert spec.lower > 0.0, spec.symbol


def test_it_names_only_effects_that_exist(effect: Effect) -> None:
    assert {*effect.includes, *effect.excludes, *effect.looks_like} <= set(EFFECTS)
    for other in effect.excludes:
        assert effect.name in EFFECTS[other].excludes
    assert effect.name not in effect.includes


def test_places_are_of_the_kind_it_states(effect: Effect) -> None:
    places = effect.places(chain())
    assert places
    assert all(place.kind == effect.place_kind for place in places)
    assert len({place.label for place in places}) == len(places)


def test_reasons_are_sentences(effect: Effect) -> None:
    """On states of which nothing is known, an effect says in words what it lacks, or nothing."""
    if not isinstance(effect, EffectAtRest):
        return
    reason = effect.lacking(chain(), bare_states([0, 1, 2]))
    assert reason is None or len(reason) > 15


def test_zero_load_gives_zero(effect: Effect) -> None:
    data = observations(measures_moments(effect))
    still = replace(data.order, motor=np.zeros_like(data.order.motor))
    n = data.n_states
    nothing = NodeLoads(np.zeros((14, 6, n)), data.angles, still, np.zeros((14, 6, n)))
    for place in effect.places(chain()):
        one = placed(effect, place).placed[-1]
        for order in (still, None):
            for term in one.terms(chain(), replace(nothing, order=order)):
                assert not np.any(term.value), term


def test_neutral_parameters_change_no_observation(effect: Effect) -> None:
    data = observations(measures_moments(effect))
    place = effect.places(chain())[0]
    neutral = {
        spec.symbol: spec.neutral
        for spec in effect.parameters
        if spec.role is not ParameterRole.NONLINEAR and not spec.inverse
    }
    seen = Observed(np.random.default_rng(1).normal(size=(1, 6, data.n_states)), data.order)
    one = PlacedEffect(effect, place, neutral)
    shift = one.observation_shift(seen)
    assert shift is None or not np.any(shift)
    inputs = Inputs(data.angles, data.wrench, data.setup)
    after = one.adjusted(inputs)
    np.testing.assert_array_equal(after.wrench, inputs.wrench)
    for changed, other in (
        (after.setup.wrench_axes, inputs.setup.wrench_axes),
        (after.setup.wrench_point, inputs.setup.wrench_point),
        *zip(after.setup.targets, inputs.setup.targets, strict=True),
    ):
        np.testing.assert_array_equal(changed.transform, other.transform)
    spring = parallel_spring(chain(), one)
    assert spring is None or not np.any(spring.torque(data.angles[spring.joint - 1]))


def test_grids_lie_within_the_bounds(effect: Effect) -> None:
    carried = node_loads(measures_moments(effect))
    shapes = {spec.symbol: spec for spec in effect.parameters if spec.role is ParameterRole.NONLINEAR}
    for place in effect.places(chain()):
        if not isinstance(effect, EffectAtRest):
            continue
        grid = effect.nonlinear_grid(place, chain(), carried)
        assert set(grid) == set(shapes)
        for symbol, values in grid.items():
            assert (np.diff(values) > 0.0).all(), (place.label, symbol)
            assert ((values >= shapes[symbol].lower) & (values <= shapes[symbol].upper)).all()


def test_driver_has_a_value_per_state(effect: Effect) -> None:
    carried = node_loads(measures_moments(effect))
    for place in effect.places(chain()):
        covariate = PlacedEffect(effect, place).covariate(chain(), carried)
        if covariate is not None:
            assert covariate.value.shape == (carried.wrench.shape[2],)
            assert np.isfinite(covariate.value).all()
            assert covariate.unit


def test_terms_name_the_effects_own_amplitudes(effect: Effect) -> None:
    data = observations(measures_moments(effect))
    carried = node_loads(measures_moments(effect))
    amplitudes = {spec.symbol for spec in effect.parameters if spec.role is ParameterRole.AMPLITUDE} | {""}
    for place in effect.places(chain()):
        one = placed(effect, place).placed[-1]
        for term in one.terms(chain(), carried):
            assert term.symbol in amplitudes
            assert term.value.shape == (data.n_states,)
            assert np.isfinite(term.value).all()


def test_a_compliance_along_a_component_is_displacement_over_load_along_it(effect: Effect) -> None:
    carried = node_loads(measures_moments(effect))
    declared = {spec.symbol: spec.along for spec in effect.parameters if spec.along is not None}
    for place in effect.places(chain()) if declared else ():
        terms = PlacedEffect(effect, place).terms(chain(), carried)
        for symbol, along in declared.items():
            own = [term for term in terms if term.symbol == symbol and term.component == along]
            assert len(own) == 1, symbol
            np.testing.assert_array_equal(own[0].value, carried.wrench[own[0].node, along])


def test_drive_bearing_and_whole_joint_declare_their_compliances() -> None:
    declared = {
        (name, spec.symbol): spec.along
        for name, effect in EFFECTS.items()
        for spec in effect.parameters
        if spec.along is not None
    }
    assert declared == {
        ("joint-translation", "tx"): 0, ("joint-translation", "ty"): 1, ("joint-translation", "tz"): 2,
        ("bearing-tilt", "x"): 3, ("bearing-tilt", "y"): 4, ("joint-compliance", "c"): 5,
        **{("joint-full", f"c{k + 1}{k + 1}"): k for k in range(6)},
    }  # fmt: skip


def column_cases() -> list[tuple[str, str]]:
    """Return (effect, symbol) of every parameter that load states could tell."""
    return [
        (name, spec.symbol)
        for name, effect in sorted(EFFECTS.items())
        for spec in effect.parameters
        if not spec.discrete and not always_lacking(effect)
    ]


def always_lacking(effect: Effect) -> bool:
    """True for effects that act on moving joints and running clocks only."""
    return any(
        word in need for need in effect.needs for word in ("sweeps", "friction runs", "clamped runs", "absolute poses")
    )


@cache
def derivatives(name: str) -> dict[str, Floats]:
    """Return symbol to (m, n): the identification's columns at the last place."""
    effect = EFFECTS[name]
    robot = placed(effect, effect.places(chain())[-1])
    data = observations(measures_moments(effect))
    own = [column for column in free_columns(robot) if column.placed == len(robot.placed) - 1]
    blocks = list(evaluate(robot, data, own))
    found = np.concatenate([block.columns for block in blocks], axis=2)
    return {column.symbol: found[row] for row, column in enumerate(own)}


def differences(name: str, spec: ParameterSpec) -> Floats:
    """Return (m, n): a central difference of the exact balance by the amplitude or parameter."""
    effect = EFFECTS[name]
    robot = placed(effect, effect.places(chain())[-1])
    one = robot.placed[-1]
    at = one.amplitude(spec.symbol) if spec.role is ParameterRole.AMPLITUDE else one.values[spec.symbol]
    step = (1e-4 if spec.role is ParameterRole.NONLINEAR else 1e-2) * abs(at)
    ends = []
    for value in (at - step, at + step):
        moved = robot.with_values({one.parameter_name(spec.symbol): 1.0 / value if spec.inverse else value})
        ends.append(predict_observations(moved, observations(measures_moments(effect))))
    return np.asarray((ends[1] - ends[0]) / (2.0 * step))


@pytest.mark.parametrize(("name", "symbol"), column_cases())
def test_columns_are_the_slope_of_the_exact_balance(name: str, symbol: str) -> None:
    spec = EFFECTS[name].spec(symbol)
    columns, exact = derivatives(name)[symbol], differences(name, spec)
    size = float(np.sqrt(np.mean(exact**2)))
    assert size > 0.0, "nothing in these states shows it"
    # In metres: rotations count at a lever of one metre.
    assert float(np.sqrt(np.mean((columns - exact) ** 2))) < COLUMN_TOLERANCE * size

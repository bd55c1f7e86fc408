"""Load cycles: order, sizes, times, the path between holds."""

from __future__ import annotations

import numpy as np
import pytest

from stiffcal.errors import InputError
from stiffcal.simulation.played.cycles import SETTLED_AFTER, LoadProgram, interpolate_between_holds, load_program
from stiffcal.simulation.settings import Loads, parse_settings


def program_of(**changes: object) -> LoadProgram:
    loads = Loads.model_validate({"levels": [0.5, 1.0], "level_scatter": 0.0, "direction_scatter_rad": 0.0, **changes})
    return load_program(loads, np.eye(3), np.random.default_rng(5))


def test_a_cycle_goes_up_and_down_and_the_other_way() -> None:
    program = program_of(directions=[[0.0, 0.0, 2.0]], max_force_N=100.0)
    assert program.wrench[:, 2].tolist() == pytest.approx([0, 50, 100, 50, 0, -50, -100, -50, 0])
    assert program.branch.tolist() == [0, 1, 1, -1, 0, 1, 1, -1, 0]
    assert program.sign.tolist() == [0, 1, 1, 1, 0, -1, -1, -1, 0]


def test_one_way_and_several_cycles() -> None:
    program = program_of(directions=[[1.0, 0.0, 0.0]], both_ways=False, cycles=2, max_force_N=100.0)
    assert program.wrench[:, 0].tolist() == pytest.approx([0, 50, 100, 50, 0, 50, 100, 50, 0])
    assert program.cycle.tolist() == [0, 0, 0, 0, 0, 1, 1, 1, 1]


def test_directions_turn_with_their_axes_and_bring_their_moment() -> None:
    loads = Loads.model_validate(
        {"levels": [1.0], "level_scatter": 0.0, "direction_scatter_rad": 0.0, "max_force_N": 10.0,
         "directions": [[1.0, 0.0, 0.0, 0.0, 0.0, 0.2]]}
    )  # fmt: skip
    quarter = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    program = load_program(loads, quarter, np.random.default_rng(0))
    np.testing.assert_allclose(program.wrench[1], [0, 10, 0, 0, 0, 2], atol=1e-12)


def test_loads_are_never_hit_exactly() -> None:
    loads = Loads.model_validate({"level_scatter": 0.03, "direction_scatter_rad": 0.01, "cycles": 40})
    program = load_program(loads, np.eye(3), np.random.default_rng(8))
    loaded = program.level > 0
    size = np.sqrt(np.sum(program.wrench[loaded, :3] ** 2, axis=1)) / (400.0 * program.level[loaded])
    assert np.std(size) == pytest.approx(0.03, rel=0.1)
    first = (program.direction == 0) & (program.sign > 0)
    assert np.std(program.wrench[first, 1] / program.wrench[first, 0]) == pytest.approx(0.01, rel=0.15)
    assert not program.wrench[~loaded].any()


def test_the_path_rises_and_is_flat_in_force_within_holds() -> None:
    program = program_of()
    time = np.linspace(-2.0, program.duration + 2.0, 20001)
    path = program.path(time)
    assert (np.diff(path) >= -1e-12).all()
    assert path[0] == 0.0
    assert path[-1] == 2 * len(program) - 1
    middle = 0.5 * (program.start + program.end)
    np.testing.assert_allclose(program.path(middle), 2 * np.arange(len(program)) + 0.5)
    np.testing.assert_allclose(program.wrench_at(program.path(middle)), program.wrench)


def test_a_ramp_is_a_straight_line_through_a_lag() -> None:
    """The closed form against the lag's differential equation τ dx/dt = u − x, integrated in small steps."""
    program = program_of(directions=[[1.0, 0.0, 0.0]], ramp_scatter=0.0, ramp_s=0.8, settle_s=0.6)
    time = np.linspace(program.ramp_from[1], program.start[1], 20001)
    lag = 0.6 / SETTLED_AFTER
    step = time[1] - time[0]
    wanted = np.clip((time - time[0]) / 0.8, 0.0, 1.0)
    state, integrated = 0.0, []
    for target in wanted:
        integrated.append(state)
        state += step / lag * (target - state)
    np.testing.assert_allclose(program.path(time)[:-1] - 1.0, integrated[:-1], atol=2e-4)
    assert program.path(time)[-2] > 2.0 - 1e-3


def test_interpolation_over_the_path() -> None:
    value = np.array([[0.0], [10.0], [20.0]])
    np.testing.assert_allclose(
        interpolate_between_holds(value, np.array([0.0, 0.9, 1.5, 2.5, 4.7, 5.0]))[:, 0], [0, 0, 5, 10, 20, 20]
    )


@pytest.mark.parametrize(
    ("document", "message"),
    [
        ({"loads": {"levles": [1.0]}}, "levles"),
        ({"loads": {"directions": [[0, 0]]}}, "write three numbers"),
        ({"loads": {"directions": [[0, 0, 0]]}}, "no force"),
        ({"loads": {"hold_s": -1}}, "hold_s"),
        ({"runs": [{"id": "a", "joints_deg": [0.0]}, {"id": "a", "joints_deg": [0.0]}]}, "two runs"),
        ({"runs": [{"id": "a", "joints_deg": [0.0], "loads": {"hold": 3}}]}, 'runs "a": loads.hold'),
        ({"runs": []}, "runs"),
        ({"sensors": {"ft": {"white": {"force": 1.0}}}}, "sensors.ft.white.force"),
        ({"schema": "stiffcal/simulate/9"}, "schema"),
    ],
)
def test_wrong_settings_are_named(document: dict[str, object], message: str) -> None:
    whole = {"schema": "stiffcal/simulate/1", "runs": [{"id": "a", "joints_deg": [0.0]}], **document}
    with pytest.raises(InputError) as caught:
        parse_settings(whole)
    assert message in str(caught.value)
    assert str(caught.value).startswith("simulate.toml: ")

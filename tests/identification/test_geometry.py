"""The geometry's tolerance in the covariance: its columns, its size, what places show, and what stays as it was."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stiffcal.identification.derivatives.observation import observe
from stiffcal.identification.fitting.geometry import (
    geometry_changes,
    geometry_columns,
    geometry_prior,
    misfit_of_places,
    with_geometry,
)
from stiffcal.identification.fitting.geometry_source import GeometrySource
from stiffcal.identification.fitting.identify import identify_parameters, predict_observations
from stiffcal.mechanics.chain import Chain, GeometryTolerance
from stiffcal.mechanics.rotations import rotation_from_vector
from tests.rates.playing import Hidden, simulate_runs

DEFAULT = GeometryTolerance(5e-4, 3.5e-4, stated=False)


def played() -> Hidden:
    return simulate_runs("none", np.random.default_rng([3, 1]))


def with_tolerance(campaign: Hidden, tolerance: GeometryTolerance) -> Hidden:
    model = campaign.model
    return replace(campaign, model=replace(model, chain=replace(model.chain, tolerance=tolerance)))


def shifted(chain: Chain, seed: int, length: float, angle: float) -> Chain:
    """Return the chain with every shift and turn between its joints off at random."""
    rng = np.random.default_rng(seed)
    fixed = chain.fixed.copy()
    for transform in fixed:
        transform[:3, :3] = transform[:3, :3] @ rotation_from_vector(angle * rng.normal(size=3))
        transform[:3, 3] += length * rng.normal(size=3)
    return replace(chain, fixed=fixed)


def test_columns_are_the_slope_of_the_exact_balance_to_a_per_cent() -> None:
    campaign = played()
    data = observe(campaign.states, campaign.truth.chain)
    columns = geometry_columns(campaign.truth, data)
    nominal = predict_observations(campaign.truth, data)
    for number in (4, 8, 14, 22):
        chain = geometry_changes(campaign.truth.chain)[number]
        exact = (predict_observations(replace(campaign.truth, chain=chain), data) - nominal) / 1e-5
        size = np.sqrt(np.mean(exact**2))
        assert np.sqrt(np.mean((columns[number] - exact) ** 2)) < 0.01 * size


def test_estimates_move_by_what_the_effect_says() -> None:
    """A fit on a robot that is off differs from the fit on the right one as the linear propagation has it."""
    campaign = with_tolerance(played(), replace(DEFAULT, stated=True))
    fit = with_geometry(identify_parameters(campaign.states, campaign.model), campaign.states)
    assert fit.covariance_from_geometry is not None
    expected = np.sqrt(np.diag(fit.covariance_from_geometry))
    moved = []
    for seed in range(6):
        chain = shifted(campaign.model.chain, seed, DEFAULT.length, DEFAULT.angle)
        other = identify_parameters(campaign.states, replace(campaign.model, chain=chain))
        values = [
            np.array([one.parameter(name).value for name in fit.free_names], dtype=np.float64) for one in (other, fit)
        ]
        moved.append(values[0] - values[1])
    # Six draws determine a standard deviation to 30 %, those of seven joints together to a fifth.
    ratio = np.sqrt(np.mean(np.square(moved), axis=0)) / expected
    assert 0.6 < np.median(ratio) < 1.5
    assert ratio.max() < 2.2


def test_only_uncertainties_change() -> None:
    campaign = with_tolerance(played(), replace(DEFAULT, stated=True))
    plain = identify_parameters(campaign.states, campaign.model)
    fit = with_geometry(plain, campaign.states)
    assert fit.noise == plain.noise
    np.testing.assert_array_equal(fit.residual, plain.residual)
    for one, other in zip(fit.parameters, plain.parameters, strict=True):
        assert one.value == other.value
        assert one.std is not None
        assert other.std is not None
        assert one.from_geometry is not None
        assert one.std == pytest.approx(other.std / np.sqrt(1.0 - one.from_geometry))
        assert 0.0 < one.from_geometry < 1.0


def test_an_exact_geometry_adds_nothing() -> None:
    campaign = with_tolerance(played(), GeometryTolerance(0.0, 0.0, stated=True))
    plain = identify_parameters(campaign.states, campaign.model)
    fit = with_geometry(plain, campaign.states)
    assert fit.parameters == plain.parameters
    assert fit.geometry is not None
    assert fit.geometry.source is GeometrySource.ROBOT_FILE


@pytest.mark.parametrize(("times", "low", "high"), [(0.0, 0.1, 0.9), (1.0, 0.6, 1.7), (10.0, 4.0, 16.0)])
def test_places_show_how_good_the_geometry_is(times: float, low: float, high: float) -> None:
    """Places of a robot that is ``times`` the tolerance off; its turned tracker and its shifted target do not count."""
    campaign = with_tolerance(played(), DEFAULT)
    states, robot = campaign.states, campaign.truth
    off = shifted(campaign.model.chain, 5, times * DEFAULT.length, times * DEFAULT.angle)
    prior = geometry_prior(states, replace(robot, chain=replace(off, tolerance=DEFAULT)))
    assert prior.source is GeometrySource.PLACES
    assert low < prior.length / DEFAULT.length < high
    turn = rotation_from_vector(np.array([0.02, -0.01, 0.03]))
    turned = replace(states, position=states.position @ turn.T + [0.1, -0.2, 0.05])
    again = geometry_prior(turned, replace(robot, chain=replace(off, tolerance=DEFAULT)))
    assert again.length == pytest.approx(prior.length, rel=0.1)


def test_without_places_the_default_counts() -> None:
    campaign = with_tolerance(played(), DEFAULT)
    unmeasured = replace(campaign.states, position=np.full_like(campaign.states.position, np.nan))
    prior = geometry_prior(unmeasured, campaign.model)
    assert prior.source is GeometrySource.DEFAULT
    assert prior.length == DEFAULT.length


def test_few_places_change_the_default_a_little() -> None:
    """Like the mean of a scaled inverse χ² of four degrees of freedom before, and those of the places."""
    campaign = with_tolerance(played(), DEFAULT)
    robot = replace(campaign.truth, chain=replace(campaign.truth.chain, tolerance=DEFAULT))
    prior = geometry_prior(campaign.states, robot)
    places = misfit_of_places(campaign.states, robot, DEFAULT)
    assert places is not None
    misfit, dof = places
    assert misfit < 0.5
    assert prior.misfit == misfit
    assert prior.angle / DEFAULT.angle == pytest.approx(np.sqrt((4.0 + dof * misfit**2) / (4.0 + dof)))


def test_no_share_is_known_of_what_has_no_variance() -> None:
    """As many numbers as readings: an answer with a share that is no number could not be read from the store again."""
    campaign = with_tolerance(played(), replace(DEFAULT, stated=True))
    fit = identify_parameters(campaign.states, campaign.model)
    covariance = fit.covariance.copy()
    covariance[:, 0] = covariance[0, :] = np.inf
    found = with_geometry(replace(fit, covariance=covariance), campaign.states)
    shares = {parameter.name: parameter.from_geometry for parameter in found.parameters}
    first, *others = fit.free_names
    assert shares[first] is None
    assert all(0.0 < (shares[name] or 0.0) < 1.0 for name in others)

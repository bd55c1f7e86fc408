"""The link's compliance from its rods: the beam's, within its interval, and as good as the rods in held-out poses."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from stiffcal.arrays import Floats
from stiffcal.campaign.loading import load_campaign
from stiffcal.links.compliance import carried_to_target, regress_compliance, share_of_tool
from stiffcal.links.rods import LinkEstimate, estimate_link
from stiffcal.measurements.load_states import Attachment, MeasurementSetup
from stiffcal.measurements.rods import BeamProperties, Rods
from stiffcal.mechanics.chain import Chain
from stiffcal.mechanics.rods import rod_matrix
from stiffcal.model.assembled.composite import CompliantRobot, PlacedEffect
from stiffcal.model.balance.equilibrium import solve_balance
from stiffcal.model.catalogue.catalogue import find_effects
from stiffcal.model.effect import Place
from tests.links.test_rods import DRAWN, LENGTH, SHAPE, compliance, paper_rods, seven_rods

NOISE = 1e-6


def loads(n: int, seed: int) -> Floats:
    """Wrenches as a swing's end carries them: forces of some 500 N, moments of their lever arms."""
    return np.random.default_rng(seed).standard_normal((n, 6)) * [500.0, 500.0, 500.0, 400.0, 400.0, 400.0]


def measured(rods: Rods, shape: BeamProperties, wrench: Floats, seed: int, noise: float = NOISE) -> LinkEstimate:
    read = wrench @ compliance(shape) @ rod_matrix(rods, shape).T
    return estimate_link(rods, shape, read + noise * np.random.default_rng(seed).standard_normal(read.shape))


@pytest.mark.parametrize("shape", [SHAPE, DRAWN], ids=["plain", "drawn"])
def test_without_noise_it_is_the_beams(shape: BeamProperties) -> None:
    wrench = loads(40, 1)
    found = regress_compliance(measured(seven_rods(), shape, wrench, 0, noise=0.0), wrench)
    truth = compliance(shape)
    assert found.structure == "symmetric"
    scale = np.sqrt(np.outer(np.diag(truth), np.diag(truth)))
    np.testing.assert_allclose(found.matrix / scale, truth / scale, atol=1e-9)


def test_interval_holds_the_beams_compliance() -> None:
    """Pooled over 40 campaigns of 60 states: the 21 elements lie within their 95 % intervals in 93–97 %."""
    truth, inside, upper = compliance(SHAPE), [], np.triu_indices(6)
    for seed in range(40):
        wrench = loads(60, 100 + seed)
        found = regress_compliance(measured(seven_rods(NOISE), SHAPE, wrench, seed), wrench)
        low, high = found.interval
        inside.append(((low <= truth) & (truth <= high))[upper])
        assert found.reduced_chi2 == pytest.approx(1.0, abs=0.35)
    assert 0.93 <= np.mean(inside) <= 0.97


def test_offset_of_each_run_is_taken_out() -> None:
    wrench, run = loads(60, 3), np.repeat([0, 1, 2], 20)
    rods = seven_rods(NOISE)
    read = wrench @ compliance(SHAPE) @ rod_matrix(rods, SHAPE).T + 40e-6 * np.array([1, -1, 2])[run][:, None]
    found = regress_compliance(estimate_link(rods, SHAPE, read), wrench, run)
    np.testing.assert_allclose(found.matrix, compliance(SHAPE), atol=1e-16)
    assert found.dof == 60 * 7 - 21 - 3 * 7
    # an offset of 40 µm left in would be forty times the noise
    assert found.reduced_chi2 < 1e-6


def test_five_rods_along_the_fibre_leave_the_twist_open() -> None:
    wrench, truth = loads(60, 5), compliance(SHAPE)
    found = regress_compliance(measured(paper_rods(NOISE), SHAPE, wrench, 6), wrench)
    reported = np.ones((6, 6), dtype=bool)
    reported[3], reported[:, 3] = False, False
    np.testing.assert_array_equal(np.isfinite(found.matrix), reported)
    assert "twist" in found.not_identifiable[0]
    low, high = found.interval
    assert np.mean(((low <= truth) & (truth <= high))[reported]) > 0.85


def test_predicts_held_out_loads_as_well_as_the_rods() -> None:
    wrench, heldout = loads(60, 7), loads(200, 8)
    found = regress_compliance(measured(seven_rods(NOISE), SHAPE, wrench, 9), wrench)
    truth = heldout @ compliance(SHAPE)
    by_rods = measured(seven_rods(NOISE), SHAPE, heldout, 10).displacement
    error, rods_error = np.std(found.predict(heldout) - truth, axis=0), np.std(by_rods - truth, axis=0)
    assert np.all(error < rods_error)
    slopes = np.einsum("nj,ijp->nip", heldout, found.slopes.reshape(6, 6, -1))
    std = np.sqrt(np.einsum("nip,pq,niq->ni", slopes, found.covariance, slopes))
    pull = (found.predict(heldout) - truth) / std
    assert 0.5 < np.sqrt(np.mean(pull**2)) < 1.6


def test_loads_in_one_direction_show_one_column() -> None:
    wrench = np.zeros((20, 6))
    wrench[:, 1] = np.linspace(-800.0, 800.0, 20)
    found = regress_compliance(measured(seven_rods(NOISE), SHAPE, wrench, 1), wrench)
    assert abs(found.matrix[1, 1] - compliance(SHAPE)[1, 1]) < 3.0 * found.std[1, 1] < 0.1 * found.matrix[1, 1]
    assert np.isnan(found.matrix[2, 2])
    assert "do not identify" in found.not_identifiable[-1]


def test_rods_that_leave_a_moment_out_take_the_link_as_a_beam() -> None:
    """Three unknowns carried, and moments on the end: the beam's compliance within its interval all the same."""
    # a drawn section's twist centre is off the axis by its solution's rounding
    shape = BeamProperties(LENGTH, twist_centre=(5e-8, -4e-7))
    rods, truth, inside = paper_rods(NOISE), compliance(shape), []
    three = ("tip force 2", "tip force 3", "tension")
    for seed in range(20):
        wrench = loads(60, 300 + seed)
        read = wrench @ truth @ rod_matrix(rods, shape).T
        read += NOISE * np.random.default_rng(seed).standard_normal(read.shape)
        found = regress_compliance(estimate_link(rods, shape, read, unknowns=three), wrench)
        assert found.structure == "beam"
        assert np.isnan(found.matrix[3, 3])
        assert np.isfinite(np.delete(np.delete(found.matrix, 3, 0), 3, 1)).all()
        low, high = found.interval
        some = ([0, 1, 2, 4, 5], [0, 1, 2, 4, 5])
        inside.append(((low <= truth) & (truth <= high))[some])
    assert 0.85 < np.mean(inside) <= 1.0


@pytest.fixture(scope="module")
def chain() -> Chain:
    return load_campaign(Path(__file__).parents[2] / "campaigns" / "irb4400", check_files=False).chain


def test_share_of_the_tool(chain: Chain) -> None:
    """Swing and drives each carried to the tool sum up to the whole; the swing alone is the robot with a stiff rest."""
    effects = find_effects()
    swing = PlacedEffect(
        effects["link-beam"], Place("links", (), "swing"), {"EI2": 3e6, "EI3": 4e6, "GJ": 2e6, "EA": 9e8}
    )
    drive = PlacedEffect(effects["joint-compliance"], Place("joints", (2,)), {"c": 1e-6})
    tool = Attachment(7, np.eye(4))
    setup = MeasurementSetup(Attachment(0, np.eye(4)), tool, (tool,), ("tool",), True)
    joints = chain.model_angles(np.deg2rad([[10.0, 20.0, 15.0, 5.0, 40.0, 0.0], [-30.0, -5.0, 30.0, 25.0, 70.0, 10.0]]))
    wrench = np.array([[100.0, -300.0, 250.0, 0.0, 0.0, 0.0], [0.0, 400.0, -100.0, 20.0, 0.0, 0.0]])

    def moved(*placed: PlacedEffect) -> Floats:
        return solve_balance(CompliantRobot(chain, placed), joints, wrench, setup).displacement[:, 0]

    whole = moved(swing, drive)
    node_wrench = _wrench_at_end(chain, joints, wrench, setup)
    shape = chain.beams["swing"].shape
    from stiffcal.mechanics.beam import beam_compliance

    tip = node_wrench @ beam_compliance(shape, (3e6, 4e6), 2e6, 9e8)
    part = carried_to_target(chain, joints, "swing", tip, tool)
    np.testing.assert_allclose(part, moved(swing), rtol=0.02, atol=2e-7)
    shares = share_of_tool(part, whole) + share_of_tool(moved(drive), whole)
    assert shares == pytest.approx(1.0, abs=0.01)


def _wrench_at_end(chain: Chain, joints: Floats, wrench: Floats, setup: MeasurementSetup) -> Floats:
    """Return (n, 6) by hand: the load at the flange, about the swing's end in its axes."""
    from stiffcal.mechanics.kinematics import attached_poses

    beam = chain.beams["swing"]
    at, turned = attached_poses(chain, joints, Attachment(beam.joint, beam.end))
    point, _ = attached_poses(chain, joints, setup.wrench_point)
    moment = wrench[:, 3:] + np.cross(point - at, wrench[:, :3])
    return np.concatenate(
        [np.einsum("nji,nj->ni", turned, wrench[:, :3]), np.einsum("nji,nj->ni", turned, moment)], axis=1
    )

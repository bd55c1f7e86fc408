"""Where a payload hangs, known within what the manifest states: one more measurement next to the places."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.stats import chi2

from stiffcal.campaign.loading import load_campaign
from stiffcal.effects.joint_compliance import JointCompliance
from stiffcal.errors import InputError
from stiffcal.identification.fitting.fit import Fit
from stiffcal.identification.fitting.identify import identify_parameters
from stiffcal.measurements.load_states import Attachment, LoadStates
from stiffcal.model.assembled.composite import CompliantRobot
from stiffcal.model.assembled.measured_frames import placed_load_point
from stiffcal.validation.heldout import left_out_residuals, search_folds
from tests.laboratory.absolute_places import absolute_states, measured_by, on_all_joints
from tests.laboratory.robots import SIX_STIFFNESS, shifted, six_axes

STATED = 0.005
AWAY = (0.006, -0.004, 0.003)
SOURCE = Path(__file__).parents[2] / "campaigns" / "absolute" / "07"
N_POSES = 60


def hung(payload: float, seed: int = 3) -> LoadStates:
    """Return places with a payload in every second pose, hung elsewhere than the set-up states."""
    chain = six_axes()
    drives = on_all_joints(JointCompliance(), 6, [{"c": 1.0 / float(k)} for k in SIX_STIFFNESS])
    states = absolute_states(chain, N_POSES, seed)
    wrench = np.zeros((N_POSES, 6))
    wrench[::2, 2] = -9.81 * payload
    true_setup = replace(states.setup, wrench_point=Attachment(7, shifted(*AWAY)))
    measured = measured_by(CompliantRobot(chain, tuple(drives)), replace(states, setup=true_setup), seed, wrench=wrench)
    stated = replace(states.setup, wrench_point=Attachment(7, np.eye(4)), load_point_sigma=STATED)
    return replace(measured, setup=stated)


def fitted(states: LoadStates, with_place: bool = True) -> Fit:
    place = (placed_load_point("payload"),) if with_place else ()
    return identify_parameters(states, CompliantRobot(six_axes(), (*place, *on_all_joints(JointCompliance(), 6))))


def test_a_heavy_payload_shows_where_it_hangs() -> None:
    fit = fitted(hung(120.0))
    truth = dict(zip((f"frame.payload.{axis}" for axis in "xyz"), AWAY, strict=True))
    truth |= {f"joint-compliance.j{k + 1}.c": 1.0 / float(SIX_STIFFNESS[k]) for k in range(6)}
    away = np.array([fit.robot.values()[name] - truth[name] for name in fit.free_names])
    assert {"frame.payload.x", "frame.payload.y"} <= set(fit.free_names)
    assert chi2.sf(float(away @ np.linalg.solve(fit.covariance, away)), len(away)) > 1e-3
    # 174 degrees of freedom: 99.9 % of the reduced χ² lie within 0.35 of 1
    assert fit.reduced_chi2 == pytest.approx(1.0, abs=0.35)
    # taken for known, 7 mm bend the wrist by 120 kg × 7 mm × 6e-5 rad/(N·m): 74 µm at 0.15 m, in half of the poses
    assert (fitted(hung(120.0), with_place=False).reduced_chi2 or 0.0) > 1.5


def test_a_light_payload_leaves_what_was_stated() -> None:
    fit = fitted(hung(0.05))
    for axis in "xyz":
        parameter = fit.parameter(f"frame.payload.{axis}")
        assert parameter.std == pytest.approx(STATED, rel=0.01)
        assert abs(parameter.value or 0.0) < 0.2 * STATED
    # what was known before counts with each fold that is left out
    left_out = left_out_residuals(fit, search_folds(fit.data)).residual
    assert np.sqrt(np.mean(left_out**2)) < 1.2 * np.sqrt(np.mean(fit.residual**2))


def test_a_place_where_nothing_hangs_is_refused(tmp_path: Path) -> None:
    folder = tmp_path / "07"
    shutil.copytree(SOURCE, folder)
    manifest = folder / "campaign.toml"
    text = manifest.read_text(encoding="utf-8")
    manifest.write_text(text.replace("[frames.payload]", "[frames.payload]\nsigma_m = 0.005"), encoding="utf-8")
    assert load_campaign(folder).manifest.frames["payload"].sigma_m == 0.005
    manifest.write_text(text.replace("[frames.target1]", "[frames.target1]\nsigma_m = 0.005"), encoding="utf-8")
    with pytest.raises(InputError) as caught:
        load_campaign(folder)
    (fault,) = caught.value.faults
    assert fault.place == "frames.target1.sigma_m"


def test_what_was_stated_counts_as_three_readings() -> None:
    """A place that the measurement says nothing of takes no degree of freedom from it."""
    states = hung(0.05)
    assert fitted(states).dof == fitted(states, with_place=False).dof
    assert fitted(hung(120.0)).dof < fitted(hung(120.0), with_place=False).dof

"""Frames marked `estimate` are found from the unloaded poses, with their uncertainty, or refused."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stiffcal.campaign.frames.frames import resolve_frames
from stiffcal.campaign.loading import load_campaign
from stiffcal.campaign.manifest.manifest import Frame, Manifest
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.mechanics.rotations import vector_from_rotation
from stiffcal.reduction.registration.registering import in_instrument_axes, register_frames
from tests.laboratory.hidden_campaigns import folder_of, reduced


def estimating(manifest: Manifest, names: tuple[str, ...]) -> Manifest:
    frames = dict(manifest.frames)
    frames |= {name: Frame(parent=frames[name].parent, estimate=True) for name in names}
    return manifest.model_copy(update={"frames": frames})


@pytest.mark.parametrize(
    ("folder", "names"),
    [("01", ("tracker",)), ("01", ("target",)), ("07", ("tracker", "target")), ("08", ("tracker", "target"))],
)
def test_frames_are_found(folder: str, names: tuple[str, ...]) -> None:
    campaign, states = load_campaign(folder_of(folder)), reduced(folder).states
    true = resolve_frames(campaign.manifest, campaign.chain)
    manifest = estimating(campaign.manifest, names)
    found = register_frames(in_instrument_axes(states), manifest, campaign.chain, names)
    assert found.n_poses == 12
    assert found.rms_m < 0.006
    for name in names:
        error = np.linalg.inv(true[name].transform) @ found.frames[name]
        off = np.concatenate([error[:3, 3], vector_from_rotation(error[:3, :3])])
        known = np.isfinite(found.uncertainty[name])
        # the robot's weight sags it by millimetres, which is no noise: wider than the stated uncertainty
        assert (np.abs(off[known]) < 6.0 * found.uncertainty[name][known]).all()
    if folder == "08":  # positions only: a target's orientation is not seen
        assert np.isnan(found.uncertainty["target"][3:]).all()


def test_too_few_poses_are_refused() -> None:
    campaign, states = load_campaign(folder_of("08")), reduced("08").states
    few = states.reference & (states.run < 3)
    manifest = estimating(campaign.manifest, ("tracker", "target"))
    with pytest.raises(InputError, match="3 different unloaded poses are too few"):
        register_frames(in_instrument_axes(states), manifest, campaign.chain, ("tracker", "target"), few)


def test_other_frames_are_refused() -> None:
    campaign, states = load_campaign(folder_of("01")), reduced("01").states
    manifest = estimating(campaign.manifest, ("ft_sensor",))
    with pytest.raises(InputError, match="unloaded poses do not determine this frame"):
        register_frames(in_instrument_axes(states), manifest, campaign.chain, ("ft_sensor",))


@pytest.mark.parametrize("wrong", ["forty degrees", "another run's"])
def test_one_run_with_other_joint_angles_is_named(wrong: str) -> None:
    campaign, states = load_campaign(folder_of("01")), reduced("01").states
    joints, own = states.joints.copy(), states.run == 4
    if wrong == "forty degrees":
        joints[own, 2] += np.radians(40.0)
    else:
        joints[own] = joints[states.run == 7][0]
    names = ("tracker",)
    with pytest.raises(InputError) as caught:
        register_frames(
            in_instrument_axes(replace(states, joints=joints)),
            estimating(campaign.manifest, names),
            campaign.chain,
            names,
        )
    assert caught.value.code is FaultCode.KINEMATICS_MISMATCH
    assert caught.value.place == f"run {states.runs[4].name}"


def test_where_more_runs_are_wrong_none_is_named() -> None:
    campaign, states = load_campaign(folder_of("01")), reduced("01").states
    joints = states.joints.copy()
    for run in (2, 4, 7):
        joints[states.run == run, 1:3] += np.radians([20.0 * run, 5.0])
    names = ("tracker",)
    with pytest.raises(InputError) as caught:
        register_frames(
            in_instrument_axes(replace(states, joints=joints)),
            estimating(campaign.manifest, names),
            campaign.chain,
            names,
        )
    assert not caught.value.place.startswith("run ")


def test_where_orientations_agree_the_lengths_of_the_robot_are_in_doubt() -> None:
    campaign, states = load_campaign(folder_of("01")), reduced("01").states
    fixed = campaign.chain.fixed.copy()
    fixed[1:4, :3, 3] *= np.array([0.6, 1.5, 0.7])[:, None]
    names, chain = ("tracker",), replace(campaign.chain, fixed=fixed)
    with pytest.raises(InputError) as caught:
        register_frames(in_instrument_axes(states), estimating(campaign.manifest, names), chain, names)
    assert (caught.value.code, caught.value.place) == (FaultCode.KINEMATICS_MISMATCH, "lengths of the robot")

"""What a registration leaves, and what of it is a convention, in words."""

from __future__ import annotations

from math import isnan
from typing import TYPE_CHECKING

from stiffcal.wording import angle, count, length, listing

if TYPE_CHECKING:
    from stiffcal.reduction.registration.frames import RegisteredFrame, RegistrationSummary


def remainder_in_words(summary: RegistrationSummary) -> str:
    """Return what the kinematics of the robot file leaves of the places by which frames were estimated."""
    turned = summary.rms_rad
    turn = "" if turned is None or isnan(turned) else f", {angle(turned)}"
    return (
        f"registration of {listing(summary.frames)} in {count(summary.n_poses, 'pose')}: before any fit the robot file "
        f"misses the measured positions by {length(summary.rms_m)}{turn} rms"
    )


def convention_in_words(name: str, frame: RegisteredFrame) -> str:
    """Return along which axes a frame stays where the manifest has it, and why.

    Parameters
    ----------
    name : of the frame. frame : one with axes by convention.
    """
    axes, others = listing(frame.by_convention or []), listing(frame.cannot_be_separated_from or [])
    return (
        f"{axes} of {name}: as in campaign.toml, by convention; the orientations in these poses do not separate a "
        f"shift of {name} from one of {others}, and predictions for other orientations depend on it"
    )

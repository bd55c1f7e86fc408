"""What of a registration is a convention, in words."""

from __future__ import annotations

from typing import TYPE_CHECKING

from stiffcal.wording import listing

if TYPE_CHECKING:
    from stiffcal.reduction.registration.frames import RegisteredFrame


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

"""How well the kinematics meets the places of the frames that were estimated, as lines of a terminal."""

from __future__ import annotations

from typing import TYPE_CHECKING

from stiffcal.cli.wording import angle, length
from stiffcal.results.registration_words import convention_in_words

if TYPE_CHECKING:
    from rich.console import Console

    from stiffcal.reduction.registration.frames import RegistrationSummary


def show_registration(console: Console, registration: RegistrationSummary | None) -> None:
    """Draw what is left between the kinematics and the measured places; nothing where no frame was estimated."""
    if registration is None:
        return
    names, turned = ", ".join(registration.frames), registration.rms_rad
    turn = "" if turned is None or turned != turned else f", {angle(turned)}"
    console.print(
        f"registration of {names} in {registration.n_poses} poses: measured and predicted positions differ by "
        f"{length(registration.rms_m)}{turn} rms",
        soft_wrap=True,
    )
    for name, frame in registration.frames.items():
        if frame.by_convention:
            console.print(convention_in_words(name, frame), soft_wrap=True)

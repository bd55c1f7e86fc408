"""What the rods of a campaign can and cannot determine, for `check`: sensible before anything is measured."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from stiffcal.wording import length, share

if TYPE_CHECKING:
    from stiffcal.campaign.loading import Campaign
    from stiffcal.measurements.load_states import MeasurementSetup


@dataclass(frozen=True, slots=True, kw_only=True)
class CheckedRods:
    """What the rods on a link can and cannot measure."""

    link: str
    """Its name."""
    rods: list[str]
    """Their names."""
    carried: list[str]
    """Parts of the link's deformation that the rods measure."""
    blind: list[str]
    """Parts that they do not."""
    spare: int
    """How many rods there are more than parts that they measure."""
    says: list[str]
    """The same in words, with the rod that would help most."""


def rod_views(campaign: Campaign, setup: MeasurementSetup) -> list[CheckedRods]:
    """Return one view per link with rods."""
    import numpy as np

    from stiffcal.planning.rods import rod_observability

    views = []
    for rods, shape in zip(setup.rods, setup.beams, strict=True):
        own_name = campaign.chain.link_names[campaign.chain.beams[rods.link].joint - 1]
        entry = campaign.robot.links.get(rods.link) or campaign.robot.links.get(own_name)
        outline = None if entry is None or entry.section is None else entry.section.outline
        view = rod_observability(rods, shape, None if outline is None else [np.array(corner) for corner in outline])
        views.append(
            CheckedRods(
                link=view.link,
                rods=list(view.rods),
                carried=list(view.carried),
                blind=list(view.blind),
                spare=view.spare,
                says=[*view.sentences, *_of_section(campaign, rods.link)],
            )
        )
    return views


def _of_section(campaign: Campaign, link: str) -> list[str]:
    """Compare the drawn section with the Euler–Bernoulli beam on it."""
    beam = campaign.chain.beams[link]
    if beam.section is None:
        return []
    along_2, along_3 = (share(part, 2) for part in beam.section.shear_share(beam.length))
    text = (
        f"shear, not included in the beam, adds {along_2} (x2) and {along_3} (x3) to the deflection of the end of "
        f"{link} by a force there: rods along the link do not measure it, oblique rods interpret it as bending and "
        "twist"
    )
    decay = beam.shape.warping_decay
    fades = "" if decay is None else f"; restrained warping at the clamp decays within {length(decay)}"
    return [text + fades]

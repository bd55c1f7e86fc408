"""The table ``[absolute]`` of `simulate.toml`."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from stiffcal.campaign.toml.typed import NotNegative, Positive, TomlTable


class AbsolutePoses(TomlTable):
    """One run of absolute places: random poses around ``joints_deg``, each measured once, with a payload or without."""

    poses: int = Field(100, ge=2, description="number of poses, each measured once")
    spread_deg: Positive = Field(
        60.0, description="joint angles are drawn evenly this far to either side of joints_deg, within limits_deg"
    )
    spread_mm: Positive = Field(
        500.0, description="positions of prismatic joints likewise, to either side of joints_deg (there mm)"
    )
    payloads_kg: Annotated[list[NotNegative], Field(min_length=1)] = Field(
        [0.0], description="payloads; each pose has one of them, drawn with equal probability"
    )
    point: str = Field("flange", description="the frame of the payload")
    interval_s: Positive = Field(20.0, description="from one pose to the next")

"""The table ``[friction]`` of `simulate.toml`."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from stiffcal.campaign.toml.typed import NotNegative, Positive, TomlTable


class FrictionMotion(TomlTable):
    """One friction run: a joint driven to and fro in the air about its pose, at one velocity after another."""

    speeds_rad_s: Annotated[list[Positive], Field(min_length=1)] = Field(
        [0.02, 0.05, 0.1, 0.2, 0.5, 1.0], description="of the joint"
    )
    reachable_rad_s: Positive | None = Field(None, description="what the drive can do, whatever is programmed")
    amplitude_deg: Positive = Field(30.0, description="of the strokes to either side of the pose")
    longest_s: Positive = Field(12.0, description="slow strokes are cut to this time")
    acceleration_rad_s2: Positive = 4.0
    approach_rad_s: Positive = Field(0.5, description="on the way to the first stroke of a speed")
    cycles: int = Field(2, ge=1, description="to and fro at each speed")
    both_ways: bool = Field(True, description="false: one stroke at each speed, always the same way")
    rest_s: Positive = Field(0.4, description="between strokes")
    rotor_inertia_kgm2: NotNegative = Field(0.0, description="of the drive, at the joint's side")
    ripple_Nm: NotNegative = Field(0.0, description="of the gear")
    ripple_per_turn: NotNegative = Field(100.0, description="waves of it on one turn of the joint")

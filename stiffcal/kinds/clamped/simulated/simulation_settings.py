"""The table ``[clamped]`` of `simulate.toml`."""

from __future__ import annotations

from pydantic import Field

from stiffcal.campaign.toml.typed import NotNegative, Positive, TomlTable


class Clamping(TomlTable):
    """One clamped run: a motor driven back and forth while the flange is held."""

    point: str = Field("flange", description="the clamped frame")
    amplitude_deg: Positive = Field(0.15, description="of the motion to either side, joint angle")
    middle_deg: float = Field(0.0, description="middle of the motion, from where the robot was clamped")
    cycles: int = Field(4, ge=1, description="back and forth")
    both_ways: bool = Field(True, description="false: to one side only, and no way back")
    period_s: Positive = Field(20.0, description="of one cycle")
    rest_s: NotNegative = Field(2.0, description="before and after")
    points: int = Field(640, ge=8, description="balances solved on each half of a cycle")
    fixture_compliance: list[float] = Field(
        [0.0] * 6, min_length=6, max_length=6, description="what the fixture really gives, m/N and rad/(N·m), base axes"
    )

"""What a customer asks of the report: the manifest's [report]."""

from __future__ import annotations

from typing import Annotated, ClassVar

from pydantic import Field

from stiffcal.campaign.typed import Name, TomlTable, at_most

MOST_SIGNATURES = 6


class ReportSettings(TomlTable):
    """Optional sections of the report.

    Attributes
    ----------
    acceptance : a section with every limit of [thresholds], the value and whether it passed.
    sign_off : roles of those who sign, such as "measured by", "approved by"; each gets a line for name, date and
        signature. Without roles there is no such section.
    """

    acceptance: bool = False
    sign_off: Annotated[tuple[Name, ...], Field(strict=False), at_most(MOST_SIGNATURES, "name fewer roles")] = ()

    look_alikes: ClassVar[dict[str, str]] = {"signoff": "sign_off", "signatures": "sign_off", "limits": "acceptance"}

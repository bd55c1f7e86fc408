"""What `trend` takes from a campaign: when it was measured, and what varies from one campaign to the next."""

from __future__ import annotations

import datetime
from typing import ClassVar

from pydantic import Field

from stiffcal.campaign.toml.typed import Positive, TomlTable


class TrendSettings(TomlTable):
    """The manifest's [trend].

    Attributes
    ----------
    date : the day of the measurement; campaigns are put in its order.
    between_campaigns : standard deviation of a parameter from one campaign to the next on an unchanged robot, as a
        share of its value: re-mounting, temperature, registration.
    parameters : the same of single parameters by full name, in the parameter's unit; for those that may be zero or have
        either sign.
    """

    date: datetime.date | None = None
    between_campaigns: Positive | None = None
    parameters: dict[str, Positive] = Field(default_factory=dict)

    look_alikes: ClassVar[dict[str, str]] = {
        "day": "date",
        "between": "between_campaigns",
        "sigma": "between_campaigns",
    }

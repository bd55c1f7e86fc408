"""One robot over many campaigns, as tables."""

from __future__ import annotations

import logging
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING

from stiffcal.errors import Progress, no_progress
from stiffcal.python.campaign_answer import CampaignAnswer
from stiffcal.python.frames import frame_of_rows
from stiffcal.stages.steps import RunContext
from stiffcal.wording import place_label

if TYPE_CHECKING:
    import pandas as pd

    from stiffcal.validation.trend_result import ChangeCause, TrendResult

logger = logging.getLogger("stiffcal")


class RobotTrend(CampaignAnswer):
    """The parameters of one robot over its campaigns; made by `stiffcal.trend`.

    Parameters
    ----------
    result : what ``stiffcal trend`` answers.
    """

    result: TrendResult

    @property
    def alarms(self) -> list[str]:
        """Names of the parameters that have changed beyond what varies between campaigns."""
        return list(self.result.alarms)

    @property
    def cause(self) -> ChangeCause | None:
        """What the first change comes from: worn joints or the set-up; None without an alarm."""
        return self.result.cause

    @property
    def values(self) -> pd.DataFrame:
        """One parameter in one campaign a row: value (of compliances the stiffness), 95 % interval, both sums.

        ``campaign`` is the folder, ``date`` ISO 8601 or None. ``sum_up`` and ``sum_down`` are the CUSUM's, in standard
        deviations; NaN where the parameter is not charted.
        """
        rows: list[dict[str, str | float | None]] = []
        for parameter in self.result.parameters:
            for number, campaign in enumerate(self.result.campaigns):
                estimate = parameter.values[number]
                low, high = (None, None) if estimate is None else estimate.interval or (None, None)
                rows.append(
                    {
                        "parameter": parameter.name,
                        "campaign": campaign.folder,
                        "date": campaign.date,
                        "value": None if estimate is None else estimate.value,
                        "low_95": low,
                        "high_95": high,
                        "unit": parameter.unit,
                        "sum_up": parameter.sum_up[number],
                        "sum_down": parameter.sum_down[number],
                    }
                )
        columns = ("parameter", "campaign", "date", "value", "low_95", "high_95", "unit", "sum_up", "sum_down")
        frame = frame_of_rows(rows, columns)
        return frame.astype(dict.fromkeys(("value", "low_95", "high_95", "sum_up", "sum_down"), "float64"))

    @property
    def changes(self) -> pd.DataFrame:
        """One parameter a row, by full name: its relative change with 95 %, what varies, and the alarm.

        ``alarm`` and ``changed_from`` are folders, None without an alarm.
        """
        rows: list[dict[str, str | float | bool | None]] = []
        for parameter in self.result.parameters:
            low, high = parameter.change_interval or (None, None)
            rows.append(
                {
                    "parameter": parameter.name,
                    "effect": parameter.effect,
                    "place": place_label(parameter.where),
                    "change": parameter.change,
                    "low_95": low,
                    "high_95": high,
                    "deviation": parameter.deviation,
                    "relative": parameter.relative,
                    "variance_from": parameter.variance_from,
                    "alarm": self._folder(parameter.alarm),
                    "changed_from": self._folder(parameter.changed_from),
                }
            )
        frame = frame_of_rows(rows, ("parameter",)).set_index("parameter")
        return frame.astype(dict.fromkeys(("change", "low_95", "high_95", "deviation"), "float64"))

    def _folder(self, number: int | None) -> str | None:
        return None if number is None else self.result.campaigns[number].folder

    def __repr__(self) -> str:
        """Return the number of campaigns, and the alarms."""
        alarms = ", ".join(self.alarms) or "none"
        return f"RobotTrend of {len(self.result.campaigns)} campaigns, alarms: {alarms}"


def follow_robot(
    folders: Iterable[str | Path],
    max_change: float | None = None,
    picture: str | Path | None = None,
    progress: Progress | None = None,
    *,
    overwrite: bool = False,
) -> RobotTrend:
    """Follow one robot over many campaigns, as ``stiffcal trend`` does.

    Parameters
    ----------
    folders : campaign folders of one robot, oldest first; where every manifest has a date in [trend], that decides.
    max_change : share by which a parameter may change; names beyond it are in ``result.exceeded``.
    picture : ``*.svg``, ``*.png`` or ``*.pdf``: draw the parameters there.
    progress : called with what is being done and the share of it, 0 to 1 or None.
    overwrite : also a picture's file that holds something stiffcal did not write.

    Raises
    ------
    InputError : fewer than two campaigns, different robots, or no parameter that all campaigns identify.
    """
    from stiffcal.commands.trend import trend_campaigns

    context = RunContext(progress=progress or no_progress, notify=logger.info, overwrite=overwrite)
    named = [Path(folder) for folder in folders]
    result = trend_campaigns(named, context, None if picture is None else Path(picture), max_change)
    for warning in result.warnings:
        logger.warning(warning)
    return RobotTrend(result)

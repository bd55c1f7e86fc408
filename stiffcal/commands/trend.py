"""One robot over many campaigns: each parameter over time, alarms of a control chart, and their cause."""

from __future__ import annotations

import math
from collections.abc import Sequence
from datetime import date
from pathlib import Path

from stiffcal.campaign.loading import load_campaign
from stiffcal.campaign.toml.naming import MANIFEST_FILE
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.stages.fit import up_to_date_fit
from stiffcal.stages.fitted_campaign import FittedCampaign
from stiffcal.stages.steps import RunContext, up_to_date_states
from stiffcal.stages.trend import trend_of
from stiffcal.trust.output_kinds import TREND_PICTURE
from stiffcal.trust.outputs import check_output, written
from stiffcal.validation.one_robot import require_one_robot
from stiffcal.validation.trend_result import TrendResult


def trend_campaigns(
    folders: Sequence[Path],
    context: RunContext | None = None,
    output: Path | None = None,
    max_change: float | None = None,
) -> TrendResult:
    """Return the parameters of one robot over many campaigns.

    Parameters
    ----------
    folders : campaign folders of one robot, in order of time; where every manifest has a date, that decides.
    context : progress and so on; its store is not used, each campaign has its own.
    output : ``*.svg``, ``*.png`` or ``*.pdf``: draw a picture there.
    max_change : share by which a parameter may change.

    Raises
    ------
    InputError : fewer than two campaigns; they are of different robots; some have a date and others none; their models
        share no parameter; an option is wrong.
    """
    context = context or RunContext()
    if len(folders) < 2:
        reason = f"{len(folders)} campaign is not a series" if folders else "no campaign is named"
        raise _wrong("DIR", reason, "give two or more campaigns of the same robot")
    if max_change is not None and not 0.0 < max_change < math.inf:
        raise _wrong("--max-change", f"{max_change:g} is not a share", "give 0.1 for a tenth")
    if output is not None:
        check_output(output, TREND_PICTURE, context.overwrite)
    loaded = [load_campaign(folder, check_files=False) for folder in folders]
    for folder, campaign in zip(folders[1:], loaded[1:], strict=True):
        require_one_robot([loaded[0].chain, campaign.chain], folders[0], folder)
    _check_dates(folders, [campaign.manifest.trend.date for campaign in loaded])
    campaigns = _in_order([_fitted(folder, context) for folder in folders])
    result = trend_of(campaigns, context, max_change, None if output is None else str(output))
    if output is not None:
        from stiffcal.report.figures.canvas import save_figure
        from stiffcal.report.figures.trend import draw_trend

        with written(output, TREND_PICTURE, context.overwrite) as temporary:
            save_figure(draw_trend(result), temporary)
    return result


def _fitted(folder: Path, context: RunContext) -> FittedCampaign:
    data = up_to_date_states(folder, context)
    return FittedCampaign(folder, data, up_to_date_fit(data, context))


def _check_dates(folders: Sequence[Path], dates: Sequence[date | None]) -> None:
    if None in dates and any(day is not None for day in dates):
        reason = "it has no date, but other campaigns have one"
        mend = "write date = 2026-03-01 in [trend] of each, or of none: then the order of the command line is used"
        file = folders[dates.index(None)] / MANIFEST_FILE
        raise InputError.at(FaultCode.KEY_MISSING, str(file), "trend.date", reason, mend)


def _in_order(campaigns: list[FittedCampaign]) -> list[FittedCampaign]:
    return sorted(campaigns, key=lambda campaign: campaign.data.campaign.manifest.trend.date or date.min)


def _wrong(option: str, reason: str, mend: str) -> InputError:
    return InputError.at(FaultCode.OPTION_INVALID, "command line", option, reason, mend)

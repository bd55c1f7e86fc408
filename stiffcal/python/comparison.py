"""Two fits next to each other: of two campaigns of one robot, or of two models on the same readings."""

from __future__ import annotations

from typing import TYPE_CHECKING

from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.measurements.rms import Rms
from stiffcal.python.answers import FittedModel
from stiffcal.python.frames import frame_of_rows
from stiffcal.report.wording import measure_text
from stiffcal.validation.change import change_of
from stiffcal.wording import place_label

if TYPE_CHECKING:
    import pandas as pd

    from stiffcal.python.session import CampaignSession


class FitComparison:
    """What changes from one fit to another.

    Parameters
    ----------
    before, after : fits.
    """

    def __init__(self, before: FittedModel, after: FittedModel) -> None:
        self.before = before
        self.after = after

    @property
    def same_readings(self) -> bool:
        """Whether both are of one campaign: what differs is then the model and not the robot."""
        return self.before.campaign == self.after.campaign

    @property
    def errors(self) -> pd.DataFrame:
        """How well each fit explains its readings: rms in m and rad of the fit and in held-out poses, and the noise."""
        rows = []
        for fit in (self.before, self.after):
            result = fit.result
            row: dict[str, str | float | None] = {"model": fit.title}
            for name, rms in (("fit", result.rms), ("heldout", result.expected_rms), ("noise", result.noise)):
                measures = Rms(None, None) if rms is None else rms
                row |= {f"{name}_m": measures.translation, f"{name}_rad": measures.rotation}
            row |= {"reduced_chi2": result.reduced_chi2, "n_parameters": len(result.free_parameters)}
            rows.append(row)
        return frame_of_rows(rows).set_index("model")

    @property
    def parameters(self) -> pd.DataFrame:
        """One parameter a row, by full name: before, after, and the change.

        ``p_value`` is the probability of so large a change by chance; NaN for fits of the same readings, which are not
        independent of each other.
        """
        first, second = (
            {parameter.name: parameter for parameter in fit.result.parameters} for fit in (self.before, self.after)
        )
        rows: list[dict[str, str | float | None]] = []
        for name in dict.fromkeys((*first, *second)):
            if name not in first or name not in second:
                only, side = (first[name], "before") if name in first else (second[name], "after")
                rows.append(
                    {
                        "parameter": name,
                        "effect": only.effect,
                        "place": place_label(only.where),
                        "unit": only.unit,
                        side: only.value,
                    }
                )
                continue
            change = change_of(first[name], second[name])
            rows.append(
                {
                    "parameter": name,
                    "effect": change.effect,
                    "place": place_label(change.where),
                    "before": change.before.value,
                    "after": change.after.value,
                    "change": change.change,
                    "relative": change.relative,
                    "std": None if self.same_readings else change.std,
                    "p_value": None if self.same_readings else change.p_value,
                    "unit": change.unit,
                }
            )
        columns = ("parameter", "effect", "place", "before", "after", "change", "relative", "std", "p_value", "unit")
        frame = frame_of_rows(rows, columns).reindex(columns=list(columns)).set_index("parameter")
        numbers = ["before", "after", "change", "relative", "std", "p_value"]
        return frame.astype(dict.fromkeys(numbers, "float64"))

    @property
    def before_after(self) -> pd.DataFrame:
        """One parameter a row, by full name: of compliances the stiffness, with the 95 % intervals of both fits.

        ``outside_interval`` is whether the value after lies outside the 95 % interval before.
        """
        from stiffcal.identification.answers.before_after import estimated_parameters, values_before_and_after

        estimates = (estimated_parameters(fit.result.parameters) for fit in (self.before, self.after))
        rows: list[dict[str, str | float | bool | None]] = []
        for value in values_before_and_after(*estimates):
            row: dict[str, str | float | bool | None] = {
                "parameter": value.name, "effect": value.effect, "place": place_label(value.where), "unit": value.unit,
            }  # fmt: skip
            for side, estimate in (("before", value.before), ("after", value.after)):
                low, high = (None, None) if estimate is None else estimate.interval or (None, None)
                row |= {side: None if estimate is None else estimate.value}
                row |= {f"{side}_low_95": low, f"{side}_high_95": high}
            rows.append(row | {"relative": value.relative, "outside_interval": value.outside_interval})
        frame = frame_of_rows(rows).set_index("parameter")
        numbers = [name for name in frame.columns if name.startswith(("before", "after", "relative"))]
        return frame.astype(dict.fromkeys(numbers, "float64"))

    def summary(self) -> str:
        """Return both errors in a line."""
        texts = []
        for fit in (self.before, self.after):
            result = fit.result
            parts = [
                f"{what} {measure_text(rms)}"
                for what, rms in (("fit", result.rms), ("held out", result.expected_rms))
                if rms
            ]
            texts += [f"{fit.title}: {', '.join(parts)}"] if parts else []
        return "; ".join(texts)

    def _repr_html_(self) -> str:
        return str(self.errors.to_html(escape=True)) + str(self.parameters.to_html(escape=True))

    def __repr__(self) -> str:
        return self.summary()


def compare_fits(before: FittedModel | CampaignSession, after: FittedModel | CampaignSession) -> FitComparison:
    """Compare two fits: the errors of both, and what changes in each parameter.

    Parameters
    ----------
    before, after : fits of two campaigns of one robot, or of two models of one campaign; a campaign is fitted first.

    Raises
    ------
    InputError : what is given is not a fit.
    """
    return FitComparison(_fit_of("before", before), _fit_of("after", after))


def _fit_of(name: str, given: object) -> FittedModel:
    from stiffcal.python.session import CampaignSession

    if isinstance(given, CampaignSession):
        return given.identify()
    if isinstance(given, FittedModel):
        return given
    reason = f"{type(given).__name__} is not a fit"
    raise InputError.at(FaultCode.OPTION_INVALID, "compare", name, reason, "give the result of identify()")

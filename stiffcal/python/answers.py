"""What the steps of a campaign answer in Python: the command's result, and tables of it."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.python.campaign_answer import CampaignAnswer
from stiffcal.python.frames import frame_of, frame_of_rows, parameters_frame
from stiffcal.quantity import LENGTH, Units, of_joint, quantity_of
from stiffcal.report.wording import length, measure_text, part
from stiffcal.results.model_words import model_words
from stiffcal.results.value_words import as_shown, value_with_unit
from stiffcal.validation.schemes import held_out
from stiffcal.wording import count, share

if TYPE_CHECKING:
    import pandas as pd

    from stiffcal.compensation.predict_result import PredictResult
    from stiffcal.identification.answers.fit_results import IdentifiedParameter
    from stiffcal.measurements.columns import Values
    from stiffcal.planning.results import PlanResult
    from stiffcal.results.history_results import HistoryResult
    from stiffcal.results.identify_result import IdentifyResult
    from stiffcal.results.validate_result import ValidateResult
    from stiffcal.validation.results import ErrorSlice


class FittedModel(CampaignAnswer):
    """A fitted model.

    Parameters
    ----------
    result : of ``identify``.
    campaign : the name of its folder; fits of one folder are of the same readings.
    title : of the model, in words.
    """

    result: IdentifyResult

    def __init__(self, result: IdentifyResult, campaign: str, title: str) -> None:
        super().__init__(result)
        self.campaign = campaign
        self.title = title

    @property
    def parameters(self) -> pd.DataFrame:
        """One parameter a row, by full name.

        ``value``, ``std``, ``low_95`` and ``high_95`` are in ``unit``, ``stiffness…`` in ``stiffness_unit``,
        ``from_geometry`` is the share of the variance that the geometry's tolerance makes; NaN where
        these data do not identify it. ``shifted`` is true of a value that what the model lacks shifts beyond its
        interval, None where the fit is not diagnosed.
        """
        return parameters_frame(self.result.parameters, self.result.shifted)

    @property
    def covariance(self) -> pd.DataFrame:
        """(p, p) of the free amplitudes, SI; of stiffness-like parameters one over the value was estimated."""
        names = self.result.free_parameters
        matrix = np.array(self.result.covariance, dtype=np.float64).reshape(len(names), len(names))
        return frame_of(matrix, index=names, columns=names)

    @property
    def correlation(self) -> pd.DataFrame:
        """(p, p) coefficients of correlation of the free parameters' estimates; NaN where one does not vary."""
        covariance = self.covariance
        std = np.sqrt(np.diag(covariance.to_numpy()))
        with np.errstate(divide="ignore", invalid="ignore"):
            coefficients = covariance.to_numpy() / np.outer(std, std)
        return frame_of(coefficients, index=covariance.index, columns=covariance.columns)

    def summary(self) -> str:
        """Return the fit in a few lines: the parameters ± 95 %, and how well they explain the readings."""
        fit = self.result
        count = f"{fit.n_states} load states" if fit.has_states else f"{fit.n_readings} readings"
        lines = [f"{self.title}: {count} in {fit.n_runs} runs"]
        lines += [f"  {line}" for line in parameter_lines(fit.parameters, fit.shifted or ())]
        noise = "not known" if fit.noise is None else measure_text(fit.noise)
        lines.append(f"fit {measure_text(fit.rms)} rms, noise {noise}")
        lines += [fit.expected_error] if fit.expected_error else []
        return "\n".join(lines)

    def __repr__(self) -> str:
        return self.summary()


def parameter_lines(parameters: Sequence[IdentifiedParameter], shifted: Collection[str] = ()) -> list[str]:
    """Return each parameter of a fit in a line, ± 95 %, as the terminal shows it.

    Parameters
    ----------
    parameters : of the fit. shifted : names of values that adding what the model lacks moves beyond their intervals.
    """
    estimates = {one.name: as_shown(one, (), shifted) for one in parameters}
    units = Units((one.quantity, [one.value]) for one in estimates.values() if one.quantity is not None)
    lines = []
    for name, one in estimates.items():
        lines.append(f"{name}: {value_with_unit(one, units.of(one.quantity or quantity_of('1')))}")
    return lines


class ModelValidation(CampaignAnswer):
    """How far a model holds in poses that its fit left out.

    Parameters
    ----------
    result : of ``validate``.
    """

    result: ValidateResult

    @property
    def passed(self) -> bool | None:
        """Whether no threshold of the campaign fails."""
        return self.result.passed

    @property
    def errors(self) -> pd.DataFrame:
        """Rms length of the residual, of the noise, and of the residual without any model, by measure; SI."""
        result = self.result
        columns = {"rms": result.rms, "noise": result.noise, "zero_model": result.zero_model}
        measures = {name: dict(rms.items()) if rms is not None else {} for name, rms in columns.items()}
        return frame_of(measures, dtype=np.float64)

    def by(self, part: str) -> pd.DataFrame:
        """Return the error in parts: ``by("run")``, direction, load, branch or joint_angle; SI."""
        result = self.result
        slices = {
            "run": result.by_run,
            "direction": result.by_direction,
            "load": result.by_load,
            "branch": result.by_branch,
            "joint_angle": result.by_joint_angle,
        }
        if part not in slices:
            mend = f"choose {', '.join(slices)}"
            raise InputError.at(FaultCode.OPTION_INVALID, "by", "part", f"unknown part {part}", mend)
        return frame_of_rows(_flat(error_slice) for error_slice in slices[part])

    def summary(self) -> str:
        """Return the error in held-out poses, runs or regions, in a line."""
        noise = "not known" if self.result.noise is None else measure_text(self.result.noise)
        return f"error in {held_out(self.result.scheme)} {measure_text(self.result.rms)} rms, noise {noise}"

    def __repr__(self) -> str:
        return self.summary()


def _flat(error_slice: ErrorSlice) -> dict[str, str | float | None]:
    """Return a row whose measures are columns, as ``rms_translation``."""
    measures = {"rms": error_slice.rms, "max": error_slice.max, "zero_model": error_slice.zero_model}
    return {
        "label": error_slice.label,
        "low": error_slice.low,
        "high": error_slice.high,
        "n": error_slice.n,
        **{f"{name}_{kind}": value for name, rms in measures.items() if rms is not None for kind, value in rms.items()},
    }


class LoadPrediction(CampaignAnswer):
    """What a fitted robot does under given loads."""

    result: PredictResult
    """The result of ``predict``."""

    @property
    def deflection(self) -> pd.DataFrame:
        """One load a row: joints in degrees, wrench, deflection of the target with standard uncertainty; base axes."""
        states = self.result.states
        joints = np.array([state.joints for state in states])
        columns: dict[str, Values] = {
            f"{name}_{unit}": of_joint(unit == LENGTH.usual.name).usual.factor * joints[:, k]
            for k, (name, unit) in enumerate(zip(self.result.joint_names, self.result.joint_units, strict=True))
        }
        wrench = np.array([state.wrench for state in states])
        columns |= {f"{name}_N": wrench[:, k] for k, name in enumerate(("Fx", "Fy", "Fz"))}
        columns |= {f"{name}_Nm": wrench[:, 3 + k] for k, name in enumerate(("Mx", "My", "Mz"))}
        deflection = np.array([state.deflection for state in states])
        std = np.sqrt([np.diagonal(state.covariance) for state in states])
        for k, (name, unit) in enumerate(
            [(f"d{axis}", "m") for axis in "xyz"] + [(f"r{axis}", "rad") for axis in "xyz"]
        ):
            columns |= {f"{name}_{unit}": deflection[:, k], f"{name}_std_{unit}": std[:, k]}
        return frame_of(columns)

    def stiffness(self, row: int = 0) -> np.ndarray[Any, np.dtype[np.float64]] | None:
        """Return (6, 6) the Cartesian stiffness at the target under one of the loads; None where a direction is rigid.

        Parameters
        ----------
        row : which load, from 0.
        """
        return self.result.states[row].cartesian_stiffness

    def summary(self) -> str:
        """Return the target's displacement, in a line."""
        largest = max((float(np.linalg.norm(state.deflection[:3])) for state in self.result.states), default=0.0)
        return f"{len(self.result.states)} loads, values from {self.result.values_from}: up to {length(largest)}"

    def __repr__(self) -> str:
        return self.summary()


class FitHistory(CampaignAnswer):
    """Every fit of a campaign.

    Parameters
    ----------
    result : of ``history``.
    """

    result: HistoryResult

    def __init__(self, result: HistoryResult) -> None:
        super().__init__(result)

    @property
    def fits(self) -> pd.DataFrame:
        """One fit a row, oldest first, by its id: the model in words, errors in m and rad; NaN where not known."""
        measures = {"heldout": "heldout_rms", "fit": "fit_rms", "noise": "noise"}
        rows = [
            {"fit": fit.id, "time": fit.time, "model": model_words(fit.model)}
            | {
                f"{name}_{unit}": math.nan if (value := part(getattr(fit, field), measure)) is None else value
                for name, field in measures.items()
                for measure, unit in (("translation", "m"), ("rotation", "rad"))
            }
            for fit in self.result.fits
        ]
        return frame_of_rows(rows, ("fit",)).set_index("fit")

    def summary(self) -> str:
        """Return each fit in a line: its model and its error in held-out data."""
        return "\n".join(
            f"fit {fit.id}: {model_words(fit.model)}: "
            + ("not validated" if fit.heldout_rms is None else f"{measure_text(fit.heldout_rms)} in held-out data")
            for fit in self.result.fits
        )

    def __repr__(self) -> str:
        return self.summary()


class MeasurementPlan(CampaignAnswer):
    """Which poses and loads to measure.

    Parameters
    ----------
    result : of ``plan``.
    """

    result: PlanResult

    def __init__(self, result: PlanResult) -> None:
        super().__init__(result)

    @property
    def runs(self) -> pd.DataFrame:
        """One run a row, in the order of measuring: joints in rad, number of loads, minutes, and its rank."""
        rows = [
            {"run": run.id}
            | {f"joint{number}_rad": float(angle) for number, angle in enumerate(run.joints, start=1)}
            | {"loads": len(run.wrench), "minutes": run.minutes, "rank": run.rank}
            for run in self.result.runs
        ]
        return frame_of_rows(rows, ("run",)).set_index("run")

    @property
    def parameters(self) -> pd.DataFrame:
        """One parameter a row, by full name: the value that is planned for, and its expected ± 95 %, in ``unit``."""
        rows = [
            {
                "parameter": one.name, "value": one.value, "unit": one.unit,
                "half_width": math.nan if one.half_width is None else one.half_width,
                "relative": math.nan if one.relative is None else one.relative, "identified": one.identified,
            }
            for one in self.result.parameters
        ]  # fmt: skip
        return frame_of_rows(rows, ("parameter",)).set_index("parameter")

    def summary(self) -> str:
        """Return how many runs there are, and how well each parameter would be known."""
        lines = [count(len(self.result.runs), "run")]
        lines += [
            f"  {one.name}: " + ("not identifiable" if one.relative is None else f"± {share(one.relative)}")
            for one in self.result.parameters
        ]
        return "\n".join(lines)

    def __repr__(self) -> str:
        return self.summary()

"""Two campaigns of one robot, before and after service: which parameter has changed, and how surely."""

from __future__ import annotations

import math
from pathlib import Path
from typing import cast

from stiffcal.documents import Origin
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.identification.answers.before_after import estimated_parameters, values_before_and_after
from stiffcal.results.identify_result import IdentifyResult
from stiffcal.stages.diagnoses.current import shifted_by_missing
from stiffcal.stages.fit import up_to_date_fit
from stiffcal.stages.steps import IDENTIFY, RunContext, up_to_date_states
from stiffcal.store.origin import worst_of
from stiffcal.validation.change import CHANCE, change_of
from stiffcal.validation.compare_result import CompareResult
from stiffcal.validation.one_robot import amplitude_of, parameters_of_robot, require_one_robot
from stiffcal.wording import significant


def compare_campaigns(before: Path, after: Path, context: RunContext | None = None) -> CompareResult:
    """Compare two campaigns' fitted parameters.

    Parameters
    ----------
    before, after : campaign folders of one robot.
    context : progress and so on; its store is not used, each campaign has its own.

    Returns
    -------
    CompareResult
        Each parameter that both models hold, and how surely it has changed.

    Raises
    ------
    InputError : the campaigns are of different robots (joints, or how their axes lie to each other), or their models
        share no parameter.
    """
    context = context or RunContext()
    fits, chains, origins, shifted = [], [], [], []
    for folder in (before, after):
        data = up_to_date_states(folder, context)
        chains.append(data.campaign.chain)
        fits.append(up_to_date_fit(data, context))
        origins.append(data.store.origin_of(IDENTIFY))
        shifted.append(shifted_by_missing(data, fits[-1]) or ())
    require_one_robot(chains, before, after)
    of_robot = parameters_of_robot([fit.parameters for fit in fits])
    first, second = ({parameter.name: parameter for parameter in parameters} for parameters in of_robot)
    shared = [name for name in first if name in second]
    if not shared:
        reason = f"its model shares no parameter with that of {before}"
        raise InputError.at(
            FaultCode.MODEL_MISMATCH, str(after), "model.toml", reason, "fit both campaigns with one model"
        )
    changes = [change_of(first[name], second[name]) for name in shared]
    chances = {change.name: change.p_value for change in changes if change.p_value is not None}
    return CompareResult(
        warnings=_warnings(fits, before, after),
        before=str(before),
        after=str(after),
        parameters=changes,
        before_after=values_before_and_after(*map(estimated_parameters, of_robot, shifted)),
        only_before=[name for name in first if name not in second],
        only_after=[name for name in second if name not in first],
        p_value_all=_together(fits),
        changed=[name for name, p_value in chances.items() if p_value * len(chances) < CHANCE],
        origin=cast(Origin, worst_of(origins)),
    )


def _together(fits: list[IdentifyResult]) -> float | None:
    """Return the probability of so large changes of all shared free parameters together by chance."""
    import numpy as np
    from scipy.special import chdtrc

    of_robot = parameters_of_robot([fit.parameters for fit in fits])
    first, second = ({parameter.name for parameter in parameters} for parameters in of_robot)
    names = [name for name in fits[0].free_parameters if name in fits[1].free_parameters and name in first & second]
    values, covariances = [], []
    for fit in fits:
        pick = [fit.free_parameters.index(name) for name in names]
        covariance = np.array(fit.covariance, dtype=np.float64).reshape((len(fit.free_parameters),) * 2)
        if fit.covariance_from_geometry is not None:
            # An error of the geometry is the same before and after.
            known = len(fit.covariance_from_geometry)
            covariance[:known, :known] -= np.array(fit.covariance_from_geometry, dtype=np.float64)
        covariances.append(covariance[np.ix_(pick, pick)])
        values.append(np.array([amplitude_of(fit.parameter(name)) for name in names]))
    difference = values[1] - values[0]
    if not names or not np.isfinite(difference).all():
        return None
    distance = difference @ np.linalg.solve(covariances[0] + covariances[1], difference)
    return float(chdtrc(len(names), distance))


def _warnings(fits: list[IdentifyResult], before: Path, after: Path) -> list[str]:
    texts = []
    of_robot = parameters_of_robot([fit.parameters for fit in fits])
    if any(len(own) < len(fit.parameters) for own, fit in zip(of_robot, fits, strict=True)):
        texts.append(
            "geometry and frames are not compared: they depend on the registration of the tracker in each campaign"
        )
    if fits[0].model != fits[1].model:
        texts.append("the two models differ: a change may come from the model and not from the robot")
    for folder, fit in zip((before, after), fits, strict=True):
        if fit.reduced_chi2 is not None and fit.reduced_chi2 > 1.5:
            size = math.sqrt(fit.reduced_chi2)
            texts.append(
                f"{folder}: residuals are {significant(size, 2)} times the noise: the stated "
                f"uncertainties are too small"
            )
    return texts

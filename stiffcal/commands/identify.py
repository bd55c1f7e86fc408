"""Fit the model to the load states."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, TypeGuard

from stiffcal.campaign.checks.prismatic_checks import refuse_prismatic
from stiffcal.documents import document_of
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.results.identify_result import IdentifyResult, Loss
from stiffcal.stages.fit import current_fit, fit_now, store_fit
from stiffcal.stages.steps import (
    DIAGNOSE,
    IDENTIFY,
    Ingested,
    RunContext,
    up_to_date_states,
)

if TYPE_CHECKING:
    from stiffcal.identification.fitting.fit import Fit

LOSSES: tuple[Loss, ...] = ("linear", "huber")


def identify_campaign(
    folder: Path,
    context: RunContext | None = None,
    loss: str = "linear",
    dual_quaternions: bool = False,
    coupling: bool = False,
) -> IdentifyResult:
    """Fit model.toml to the campaign's load states.

    Parameters
    ----------
    folder : the campaign folder.
    context : store, progress and so on.
    loss : "linear" (least squares) or "huber" (outliers count less).
    dual_quaternions : identify joint compliances in paper 003's form too, and report how the two agree.
    coupling : with rods on a link, identify without them too, and show what the joints are then mistaken by.

    Returns
    -------
    IdentifyResult
        Where nothing has changed since the last fit, that one.

    Raises
    ------
    InputError : the input is wrong, or nothing can be fitted.
    """
    context = context or RunContext()
    if not is_loss(loss):
        raise InputError.at(
            FaultCode.OPTION_INVALID,
            "command line",
            "--loss",
            f"unknown loss {loss}",
            f"choose {' or '.join(LOSSES)}",
        )
    data = up_to_date_states(folder, context)
    current = current_fit(data, loss)
    if current is not None:
        context.notify(f"nothing has changed since fit {current.fit_id}")
    result = current
    if result is None or (dual_quaternions and result.dual_quaternions is None):
        fit = fit_now(data, loss, context)
        result = result or store_fit(data, fit, loss)
        result = _add_dual_quaternion_form(data, fit, result) if dual_quaternions else result
    if coupling and result.coupling is None:
        from stiffcal.stages.coupling import with_coupling

        result = with_coupling(data, result, loss, context)
    result = replace(result, origin=data.store.origin_of(IDENTIFY))
    if DIAGNOSE not in data.store.documents:
        return result
    from stiffcal.stages.diagnoses.current import shifted_by_missing

    shifted = shifted_by_missing(data, result)
    return replace(result, shifted=None if shifted is None else sorted(shifted))


def is_loss(loss: str) -> TypeGuard[Loss]:
    """Return whether there is a loss of this name."""
    return loss in LOSSES


def _add_dual_quaternion_form(data: Ingested, fit: Fit | None, result: IdentifyResult) -> IdentifyResult:
    """Add the joint compliances in dual quaternions (Li et al. 2019, paper 003) to a fit, and commit it to the store.

    Raises
    ------
    InputError : the model holds more than joint springs.
    """
    from stiffcal.identification.answers.dual_form import identify_in_two_forms, two_forms_result

    refuse_prismatic(
        data.campaign.chain.prismatic_names,
        "the form in dual quaternions turns all joints",
        "leave --dual-quaternions out",
    )
    if fit is None:
        reason = "the campaign contains no load states to identify springs from"
        raise InputError.at(FaultCode.DATA_MISSING, "command line", "--dual-quaternions", reason, "leave it out")
    result = replace(result, dual_quaternions=two_forms_result(identify_in_two_forms(fit)))
    data.commit({}, {IDENTIFY: document_of(result)}, command="identify")
    return result

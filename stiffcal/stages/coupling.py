"""`identify --coupling`: the same load states identified with the rods and without them, side by side."""

from __future__ import annotations

from dataclasses import replace

from stiffcal.documents import document_of
from stiffcal.errors import InputError
from stiffcal.escapes.shell import command_line
from stiffcal.fault_codes import FaultCode
from stiffcal.model.catalogue.campaign_effects import placed_robot
from stiffcal.results.identify_result import IdentifyResult
from stiffcal.stages.steps import IDENTIFY, Ingested, RunContext


def with_coupling(data: Ingested, result: IdentifyResult, loss: str, context: RunContext) -> IdentifyResult:
    """Add the coupling errors of a campaign with rods to a fit, in the store too.

    Raises
    ------
    InputError : no rods, or a model that lets no link with rods give.
    """
    from stiffcal.identification.answers.coupling import coupling_result, identify_both_ways
    from stiffcal.identification.fitting.identify import Settings
    from stiffcal.model.assembled.assembly import fixed_parameters

    rodded = [rods.link for rods in data.states.setup.rods]
    robot = placed_robot(data.campaign)
    if not rodded:
        reason = "no link carries rods: nothing to compare"
        raise InputError.at(
            FaultCode.DATA_MISSING, "command line", "--coupling", reason, "leave it out, or add [ids] and lengths"
        )
    if not any(placed_effect.place.link in rodded for placed_effect in robot.placed):
        reason = f"the model contains no compliance of a link with rods ({', '.join(rodded)})"
        raise InputError.at(
            FaultCode.MODEL_UNSUITABLE,
            "command line",
            "--coupling",
            reason,
            command_line("add", data.campaign.folder, "link-beam", "--links", rodded[0]),
        )
    settings = Settings(loss=loss, fixed=fixed_parameters(data.campaign.model))
    coupling = identify_both_ways(data.states, robot, settings, context.progress)
    result = replace(result, coupling=coupling_result(coupling))
    data.commit({}, {IDENTIFY: document_of(result)}, command="identify")
    return result

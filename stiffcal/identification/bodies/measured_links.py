"""Links that carry rods, in a campaign: how each has moved, what it carried, and its share of the tool's deflection.

This needs a model only to turn the load into what the link's end carries, and for that a rigid robot is nearly as good
as a fitted one: levers change by well under a percent. Nothing of the joints' stiffness goes into the rods' result.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from stiffcal.arrays import Floats, Integers
from stiffcal.identification.bodies.link_results import LinkResult, NotCarried, RodFaultResult, TorsionResult
from stiffcal.identification.derivatives.observation import rests
from stiffcal.identification.derivatives.state_blocks import state_blocks
from stiffcal.identification.readings.observations import Observations
from stiffcal.identification.readings.row_layout import GAUGE, LENGTH, TRANSLATION
from stiffcal.links.compliance import LinkCompliance, carried_to_target, regress_compliance
from stiffcal.links.rods import LinkEstimate, bounded_by_load, estimate_link
from stiffcal.measurements.rods import BeamProperties, Rods
from stiffcal.mistakes.rods.faults import RodFault, find_rod_faults
from stiffcal.model.assembled.composite import CompliantRobot
from stiffcal.model.effect import link_node


@dataclass(frozen=True)
class MeasuredLink:
    """A link with rods, in n states in which all its rods were read."""

    link: str
    """Its name."""
    index: Integers
    """(n,) the states' places among the observations."""
    run: Integers
    """(n,) their runs."""
    estimate: LinkEstimate
    """How its outboard end moved since the run's reference, beam axes."""
    wrench: Floats
    """(n, 6) what its end carried beyond weight, beam axes, N and N·m."""
    at_tool: Floats
    """(n, 6) what that displacement moves the first target by, base axes, m and rad; a twist that no rod measures
    counts as none.
    """
    share: float
    """Of the measured deflection, which part runs along it; NaN where no deflection was measured."""
    compliance: LinkCompliance
    """Regressed on the wrench."""
    faults: tuple[RodFault, ...]
    """Rods that cannot be right."""


def measure_links(data: Observations, robot: CompliantRobot, sigma: float | None = None) -> tuple[MeasuredLink, ...]:
    """Measure every link that carries rods.

    Parameters
    ----------
    data : the observations.
    robot : the chain, with whatever effects are known; none will do.
    sigma : standard uncertainty of a rod's reading in one state, m, by repeats; None: as the manifest states.
        The reference reading's own is not in it: it is the same for all states of a run.
    """
    measured_links = []
    wrenches = _node_wrenches(data, robot) if data.layout.rods else np.zeros((0, 6, 0))
    for number, (rods, shape) in enumerate(zip(data.setup.rods, data.setup.beams, strict=True)):
        rod_rows = np.flatnonzero((data.layout.kind == LENGTH) & (data.layout.body == number))
        if not len(rod_rows):
            continue
        rods_read = rods.pick(data.layout.component[rod_rows])
        if sigma is not None and sigma > 0.0:
            rods_read = replace(rods_read, sigma=np.full(len(rod_rows), sigma))
        node = link_node(robot.chain.beams[rods.link].joint)
        measured_links.append(_measure_link(data, robot, rods_read, shape, rod_rows, wrenches[node].T))
    return tuple(measured_links)


def _measure_link(
    data: Observations, robot: CompliantRobot, rods: Rods, shape: BeamProperties, rows: Integers, wrench: Floats
) -> MeasuredLink:
    index = np.flatnonzero(data.measured_mask[rows].all(axis=0))
    lengths, run, carried = data.measured[np.ix_(rows, index)].T, data.run[index], wrench[index]
    estimate = estimate_link(rods, shape, lengths)
    angles = np.ascontiguousarray(data.angles[:, index].T)
    targets = [carried_to_target(robot.chain, angles, rods.link, estimate.untwisted, t) for t in data.setup.targets]
    time = data.order.time[index]
    compliance = regress_compliance(estimate, carried, run)
    bounded = bounded_by_load(estimate.torsion, carried[:, 3], np.diag(compliance.matrix)[4:])
    estimate = replace(estimate, torsion=bounded)
    compliance = compliance if compliance.twist is None else replace(compliance, twist=bounded)
    return MeasuredLink(
        link=rods.link,
        index=index,
        run=run,
        estimate=estimate,
        wrench=carried,
        at_tool=targets[0] if targets else np.full((len(index), 6), np.nan),
        share=_share(data, index, targets),
        compliance=compliance,
        faults=find_rod_faults(rods, shape, lengths, carried, time, run, data.order.temperature[index]),
    )


def _node_wrenches(data: Observations, robot: CompliantRobot) -> Floats:
    """Return (2J + 2, 6, n) what the load alone makes the nodes carry, node axes."""
    wrench = np.empty((2 * robot.chain.n_joints + 2, 6, data.n_states))
    for rows in state_blocks(robot, data):
        loaded, unloaded = rests(robot, data.subset(rows))
        wrench[:, :, rows] = loaded.wrench - unloaded.wrench
    return wrench


def _share(data: Observations, index: Integers, targets: list[Floats]) -> float:
    """Return the link's share of what was measured of the targets' deflection, along that deflection.

    Both are counted within a run from its own mean, so that the reference reading's noise does not matter.
    """
    rows = np.flatnonzero((data.layout.kind == TRANSLATION) | (data.layout.kind == GAUGE))
    if not targets or not len(rows):
        return np.nan
    subset = data.subset(index)
    of_link = subset.layout.of_targets(np.moveaxis(np.stack(targets), 1, -1))[rows]
    measured_mask, measured = subset.measured_mask[rows], subset.measured[rows]
    along = squares = 0.0
    for run in np.unique(subset.run):
        for row in range(len(rows)):
            members = (subset.run == run) & measured_mask[row]
            if members.any():
                centred = measured[row, members] - measured[row, members].mean()
                along += float(centred @ of_link[row, members])
                squares += float(centred @ centred)
    return along / squares if squares > 0.0 else np.nan


def link_results(links: tuple[MeasuredLink, ...]) -> list[LinkResult]:
    """Return links with rods as ``identify`` answers them: SI, beam axes, None where not known."""
    return [_link_result(link) for link in links]


def _link_result(link: MeasuredLink) -> LinkResult:
    estimate, compliance = link.estimate, link.compliance
    return LinkResult(
        link=link.link,
        rods=list(estimate.rods.names),
        n_states=len(link.index),
        carried=list(estimate.carried),
        spare=estimate.redundancy,
        condition=_number(estimate.condition),
        sigma=_number(float(np.sqrt(np.mean(estimate.sigma**2)))),
        sigma_source=estimate.sigma_source,
        displacement_std=_numbers(np.sqrt(np.diag(estimate.covariance))),
        share_of_tool=_number(link.share),
        torsion=TorsionResult(
            identifiable=estimate.torsion.identifiable, bound=estimate.torsion.bound, why=estimate.torsion.why
        ),
        compliance_structure=compliance.structure,
        compliance=[_numbers(row) for row in compliance.matrix],
        compliance_std=[_numbers(row) for row in compliance.std],
        compliance_interval=[[_numbers(row) for row in end] for end in compliance.interval],
        reduced_chi2=_number(compliance.reduced_chi2),
        not_identifiable=list(compliance.not_identifiable),
        not_carried=[NotCarried(load=error.load, relative_error=error.relative) for error in estimate.shape_errors],
        faults=[
            RodFaultResult(
                kind=fault.kind,
                rods=list(fault.rods),
                size_m=fault.size,
                alternatives=list(fault.alternatives),
                why=fault.sentence,
            )
            for fault in link.faults
        ],
    )


def _number(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None


def _numbers(values: Floats) -> list[float | None]:
    return [_number(float(value)) for value in values]

"""What the links themselves do to a predicted deflection: the tool with them and without them (000, Fig. 7)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.links.compliance import carried_to_target
from stiffcal.measurements.load_states import MeasurementSetup
from stiffcal.model.assembled.composite import CompliantRobot
from stiffcal.model.balance.equilibrium import rest_under_weight, solve_balance
from stiffcal.model.balance.rest import find_rest
from stiffcal.model.effect import Inputs, StateOrder, link_node


@dataclass(frozen=True)
class LinkPart:
    """A link's part in n predicted states."""

    link: str
    """Its name."""
    carried: Floats
    """(n, 6) what its outboard end carries of the load, beam axes, N and N·m."""
    end: Floats | None
    """(n, 6) how far that moves its outboard end by the model's effects on the link, beam axes, m and rad."""
    at_target: Floats | None
    """(n, 6) what the first target's deflection loses where the link is rigid, base axes, m and rad. None, like
    ``end``, where the model holds nothing on the link.
    """
    end_by_compliance: Floats | None
    """Like ``end``, by the 6×6 compliance that the link's rods gave, in place of the model; None where no rods are on
    it. A twist that the rods do not measure is the model's, else none.
    """
    at_target_by_compliance: Floats | None
    """Like ``at_target``, by the same compliance."""


def links_rigid(
    robot: CompliantRobot,
    angles: Floats,
    wrench: Floats,
    setup: MeasurementSetup,
    order: StateOrder | None,
    *links: str,
) -> Floats:
    """Return (n, 6) the first target's deflection with these links rigid and all else the same, base axes, m, rad."""
    without_links = replace(
        robot, placed=tuple(placed_effect for placed_effect in robot.placed if placed_effect.place.link not in links)
    )
    return solve_balance(without_links, angles, wrench, setup, order).displacement[:, 0]


def link_parts(
    robot: CompliantRobot,
    angles: Floats,
    wrench: Floats,
    setup: MeasurementSetup,
    order: StateOrder | None,
    compliances: Mapping[str, Floats],
) -> tuple[LinkPart, ...]:
    """Return the part of every link that the model lets give, or that rods have measured.

    Parameters
    ----------
    robot : with values.
    angles : (n, J) model angles, rad.
    wrench : (n, 6) acting as the set-up states.
    order : of the states, for laws with a memory; None where each stands alone.
    compliances : (6, 6) by link: its end's displacement per wrench there, beam axes; NaN where not known.
    """
    modelled = {placed_effect.place.link for placed_effect in robot.placed if placed_effect.place.kind == "links"}
    names = [name for name in robot.chain.beams if name in modelled or name in compliances]
    if not names:
        return ()
    inputs = Inputs(np.ascontiguousarray(angles.T), np.ascontiguousarray(wrench.T), setup)
    unloaded = rest_under_weight(robot, inputs, order=order)
    loaded = find_rest(robot, inputs, order, unloaded.wrench, unloaded.displacement)
    displacement = solve_balance(robot, angles, wrench, setup, order).displacement[:, 0]
    standing = np.moveaxis(loaded.displacement, -1, 0)
    parts = []
    for name in names:
        node = link_node(robot.chain.beams[name].joint)
        carried = (loaded.wrench[node] - unloaded.wrench[node]).T
        end = at_target = end_by = at_by = None
        if name in modelled:
            end = (loaded.displacement[node] - unloaded.displacement[node]).T
            at_target = displacement - links_rigid(robot, angles, wrench, setup, order, name)
        if name in compliances:
            end_by = carried @ np.nan_to_num(compliances[name]).T
            if end is not None and not np.isfinite(compliances[name][3, 3]):
                end_by[:, 3] = end[:, 3]
            at_by = carried_to_target(robot.chain, angles, name, end_by, setup.targets[0], standing)
        parts.append(LinkPart(name, carried, end, at_target, end_by, at_by))
    return tuple(parts)

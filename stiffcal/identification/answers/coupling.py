"""What measuring at the tool alone does to the joints' stiffness, and what rods on a link change (000, section 2).

A test at the tool measures all parts at once, and what one part does is laid at another's door: the paper's coupling
errors. Four identifications of the same load states show them: the links taken as rigid, as most do; everything at once
from the tool alone; the links' part taken out, as their rods give it, and the joints identified from what remains; and
everything from tool and rods together.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from stiffcal.errors import Progress, no_progress
from stiffcal.estimation.parameters import Parameter
from stiffcal.identification.bodies.link_noise import spread_by_rods
from stiffcal.identification.bodies.link_results import CoupledEstimate, CouplingResult, CouplingWay, Way
from stiffcal.identification.bodies.measured_links import MeasuredLink, measure_links
from stiffcal.identification.fitting.fit import Fit
from stiffcal.identification.fitting.identify import Settings, fit_rms, identify_parameters
from stiffcal.identification.readings.observations import observe
from stiffcal.links.compliance import carried_to_target
from stiffcal.measurements.load_states import LoadStates
from stiffcal.measurements.rms import Rms
from stiffcal.measurements.set_aside import SetAsideCode
from stiffcal.mechanics.chain import Chain
from stiffcal.mechanics.rotations import rotation_from_vector
from stiffcal.model.assembled.composite import CompliantRobot, PlacedEffect
from stiffcal.model.effect import RX, NodeLoads
from stiffcal.reduction.loads.motion import gauge_directions

WORDS: dict[Way, str] = {
    "links-rigid": "tool alone, links taken as rigid",
    "tool-alone": "tool alone, all parameters",
    "links-taken-out": "link deflection subtracted with the rods",
    "with-rods": "tool and rods together",
}


@dataclass(frozen=True)
class Coupling:
    """The same load states, identified in four ways."""

    fits: dict[Way, Fit]
    """By way."""
    links: tuple[str, ...]
    """The links that carry rods."""
    by_rods: dict[str, float] = field(default_factory=dict)
    """Standard uncertainty that the rods' noise leaves where the links' part was taken out, of amplitudes; the fit of
    what remains does not depend on it.
    """

    def values(self, way: Way) -> dict[str, tuple[float, float]]:
        """Return each identified parameter's value and standard uncertainty."""
        more = self.by_rods if way == "links-taken-out" else {}
        return {
            parameter.name: (
                float(parameter.value),
                float(np.hypot(parameter.std, _of_value(parameter, more.get(parameter.name, 0.0)))),
            )
            for parameter in self.fits[way].parameters
            if parameter.identifiable
            and not parameter.fixed
            and parameter.value is not None
            and parameter.std is not None
            and np.isfinite([parameter.value, parameter.std]).all()
        }


def identify_both_ways(
    states: LoadStates, robot: CompliantRobot, settings: Settings | None = None, progress: Progress = no_progress
) -> Coupling:
    """Identify with the rods and without them.

    Parameters
    ----------
    states : with rods on one link or more.
    robot : the whole model, links included; without values.
    settings : see `identify_parameters`.
    """
    settings = settings or Settings()
    rodded = tuple(rods.link for rods in states.setup.rods)
    alone = without_rods(states)
    jointed = replace(
        robot, placed=tuple(placed_effect for placed_effect in robot.placed if placed_effect.place.kind != "links")
    )
    links = measure_links(observe(states, robot.chain), CompliantRobot(robot.chain, ()))
    without_links_robot, fixed_names = without_measured_links(robot, links)
    taken_out = replace(settings, fixed=settings.fixed | fixed_names)
    ways: tuple[tuple[Way, LoadStates, CompliantRobot, Settings], ...] = (
        ("links-rigid", alone, jointed, settings),
        ("tool-alone", alone, robot, settings),
        ("links-taken-out", without_links(states, robot.chain, links), without_links_robot, taken_out),
        ("with-rods", states, robot, settings),
    )
    fits: dict[Way, Fit] = {}
    for direction, these, model, settings_of_way in ways:
        progress(f"identifying: {WORDS[direction]}", None)
        fits[direction] = identify_parameters(these, model, settings_of_way)
    by_rods = spread_by_rods(fits["links-taken-out"], links, observe(states, robot.chain))
    return Coupling(fits, rodded, by_rods)


def _of_value(parameter: Parameter, spread: float) -> float:
    """Return the spread of a parameter's value where its amplitude spreads so; a stiffness is one over it."""
    return spread * float(parameter.value) ** 2 if parameter.spec.inverse and parameter.value is not None else spread


def without_measured_links(
    robot: CompliantRobot, links: tuple[MeasuredLink, ...]
) -> tuple[CompliantRobot, frozenset[str]]:
    """Return the model of what is left when the rods' part is out, and its parameters that are held.

    A link whose twist the rods do not determine may still twist, and does nothing else.
    """
    twists = {link.link for link in links if not np.isfinite(link.compliance.matrix[3, 3])}
    rodded = {link.link for link in links}
    placed, fixed_names = [], set()
    for placed_effect in robot.placed:
        if placed_effect.place.link not in rodded:
            placed.append(placed_effect)
            continue
        twisting = _twisting_symbols(placed_effect, robot) if placed_effect.place.link in twists else set()
        other_specs = [spec for spec in placed_effect.effect.parameters if spec.symbol not in twisting]
        if twisting and all(spec.inverse for spec in other_specs):
            placed.append(
                replace(placed_effect, values={**placed_effect.values, **{spec.symbol: np.inf for spec in other_specs}})
            )
            fixed_names |= {placed_effect.parameter_name(spec.symbol) for spec in other_specs}
    return replace(robot, placed=tuple(placed)), frozenset(fixed_names)


def _twisting_symbols(placed_effect: PlacedEffect, robot: CompliantRobot) -> set[str]:
    """Return the parameters of a link's law that turn its end about the link and do nothing else."""
    wrench = np.ones((2 * robot.chain.n_joints + 2, 6, 1))
    loads = NodeLoads(wrench, np.zeros((robot.chain.n_joints, 1)))
    components_of: dict[str, set[int]] = {}
    for term in placed_effect.terms(robot.chain, loads):
        components_of.setdefault(term.symbol, set()).add(term.component)
    return {symbol for symbol, components in components_of.items() if components == {RX}}


def without_rods(states: LoadStates) -> LoadStates:
    """Return the states as if the links carried no rods."""
    setup = replace(states.setup, rods=(), beams=(), sigma=replace(states.setup.sigma, length=None))
    return replace(states, lengths=np.zeros((len(states), 0)), setup=setup)


def without_links(states: LoadStates, chain: Chain, links: tuple[MeasuredLink, ...]) -> LoadStates:
    """Take out of the measured motion that of the links as the rods measured it; states without rods are set aside.

    Taken out is the compliance that they give, under the load of each state: the readings of single states would
    bring their noise along, magnified at the tool. A twist that no rod measures stays in. The rods are gone from
    what is returned.
    """
    data = observe(states, chain)
    position, rotation = states.position.copy(), states.rotation.copy()
    deflection, gauges = states.deflection.copy(), states.displacement.copy()
    has_rods = np.ones(len(states), dtype=np.bool_)
    directions = gauge_directions(states, chain) if states.setup.gauges else None
    for link in links:
        where = data.index[link.index]
        has_rods &= np.isin(np.arange(len(states)), where)
        angles = np.ascontiguousarray(data.angles[:, link.index].T)
        displacement = link.compliance.predict(link.wrench)
        for body, target in enumerate(states.setup.targets):
            at_target = carried_to_target(chain, angles, link.link, displacement, target)
            position[where, body] -= at_target[:, :3]
            rotation[where, body] = np.swapaxes(rotation_from_vector(at_target[:, 3:]), -1, -2) @ rotation[where, body]
            deflection[where, body] -= at_target
            for number, gauge in enumerate(states.setup.gauges):
                if directions is not None and gauge.target == body:
                    gauges[where, number] -= np.einsum("ni,ni->n", directions[where, number], at_target[:, :3])
    freed = replace(states, position=position, rotation=rotation, deflection=deflection, displacement=gauges)
    return without_rods(
        freed.with_set_aside(states.used & ~has_rods, SetAsideCode.RODS_NOT_READ, "no reading of the rods")
    )


def coupling_result(coupling: Coupling) -> CouplingResult:
    """Return the four ways next to each other; SI, None where a way does not identify a parameter."""
    ways = {direction: coupling.values(direction) for direction in coupling.fits}
    names = [parameter.name for parameter in coupling.fits["with-rods"].parameters]
    return CouplingResult(
        links=list(coupling.links),
        ways=[_coupling_way(direction, fit, names) for direction, fit in coupling.fits.items()],
        parameters=[
            {
                "name": name,
                "links-rigid": _estimate(name, ways["links-rigid"], ways["with-rods"]),
                "tool-alone": _estimate(name, ways["tool-alone"], ways["with-rods"]),
                "links-taken-out": _estimate(name, ways["links-taken-out"], ways["with-rods"]),
                "with-rods": _estimate(name, ways["with-rods"], ways["with-rods"]),
            }
            for name in names
        ],
    )


def _coupling_way(way: Way, fit: Fit, names: list[str]) -> CouplingWay:
    estimated = {parameter.name for parameter in fit.parameters if not parameter.fixed}
    return CouplingWay(
        way=way,
        says=WORDS[way],
        rms=Rms.of(fit_rms(fit)),
        condition=float(fit.condition) if np.isfinite(fit.condition) else None,
        not_identifiable=sorted({name for ambiguity in fit.ambiguities for name in ambiguity.names}),
        left_out=[name for name in names if name not in estimated],
    )


def _estimate(
    name: str, values: dict[str, tuple[float, float]], reference: dict[str, tuple[float, float]]
) -> CoupledEstimate | None:
    if name not in values:
        return None
    value, std = values[name]
    return CoupledEstimate(value=value, std=std, against_rods=_against(values[name], reference.get(name)))


def _against(value: tuple[float, float], reference: tuple[float, float] | None) -> float | None:
    """Return the relative difference from the value that tool and rods together give."""
    return None if reference is None or reference[0] == 0.0 else value[0] / reference[0] - 1.0

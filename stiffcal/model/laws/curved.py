"""Springs across a joint that may be curved: δ = c w + c2 w² + c3 w³, direction by direction (paper 001, III.C).

Where a straight line through a joint's displacements does not do, paper 001 takes a curve. The law's curved form has
two more amplitudes to each direction, named by the direction's symbol and 2 or 3: ``x2``, ``x3``, ``tz2``.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from stiffcal.model.effect import NodeLoads, ParameterSpec, Place, Term, Values, joint_node
from stiffcal.model.scalar_laws import LawForm, ScalarLaw

POWERS = (2, 3)
_SOURCE = (
    "slope of the straight line changed by a third at {load:g} {unit}, as for rotations in Schneider et al. 2014, "
    "Fig. 2"
)


def curve_specs(straight: ParameterSpec, load: float, largest: float) -> tuple[ParameterSpec, ...]:
    """Return the square's and the cube's amplitude in addition to a straight spring.

    Parameters
    ----------
    straight : the spring's, its unit one of displacement over load.
    load : a usual load, N or N·m.
    largest : bound of the change at it, displacement over load.
    """
    unit = straight.unit.partition("/")[2].strip("()")
    source = _SOURCE.format(load=load, unit=unit)
    displacement = straight.unit.partition("/")[0]
    specs = []
    for power, exponent, word in ((2, "²", "square"), (3, "³", "cube")):
        size = straight.typical / (power * 3.0 * load ** (power - 1))
        bound = largest / load ** (power - 1)
        meaning = f"{word} of the load: {straight.meaning.removeprefix('compliance ')}"
        symbol = f"{straight.symbol}{power}"
        of = f"({unit})" if "·" in unit else unit
        specs.append(ParameterSpec(symbol, f"{displacement}/{of}{exponent}", meaning, -bound, bound, size, source))
    return tuple(specs)


def curve_symbols(axes: Iterable[str]) -> tuple[str, ...]:
    """Return the amplitudes' symbols of a curve along these axes.

    Examples
    --------
    >>> curve_symbols(("x", "y"))
    ('x2', 'x3', 'y2', 'y3')
    """
    return tuple(f"{axis}{power}" for axis in axes for power in POWERS)


def curved_terms(place: Place, loads: NodeLoads, axes: Mapping[str, int]) -> Sequence[Term]:
    """Return the terms of straight lines, squares and cubes.

    Parameters
    ----------
    axes : symbol to component of the joint's node.
    """
    node = joint_node(place.joints[0])
    terms = []
    for symbol, axis in axes.items():
        load = loads.wrench[node, axis]
        terms.append(Term(node, axis, symbol, load))
        terms += [Term(node, axis, f"{symbol}{power}", load**power) for power in POWERS]
    return terms


def curved_laws(place: Place, values: Values, axes: Mapping[str, int]) -> Sequence[ScalarLaw]:
    """Return the laws of `curved_terms` as data; ``values`` are amplitudes by symbol."""
    node = joint_node(place.joints[0])
    return tuple(
        ScalarLaw(
            LawForm.POLYNOMIAL,
            tuple(values[f"{symbol}{power}"] for power in ("", *POWERS)),
            ((node, axis, 1.0),),
        )
        for symbol, axis in axes.items()
    )

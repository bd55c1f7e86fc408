"""A node that gives along and about each of its axes by itself: six compliances that do not couple."""

from __future__ import annotations

from dataclasses import dataclass

from stiffcal.model.effect import RX, RY, RZ, TX, TY, TZ, NodeLoads, ParameterSpec, Term

AXES = {"rx": RX, "ry": RY, "rz": RZ, "tx": TX, "ty": TY, "tz": TZ}
"""Symbol to component of the node's displacement and wrench."""


@dataclass(frozen=True)
class CompliantAxis:
    """How much a node may give about (or along) an axis."""

    meaning: str
    """In words, with ``{axis}`` where the axis is named."""
    upper: float
    """Upper bound, rad/(N·m) or m/N."""
    typical: float
    """Typical value, rad/(N·m) or m/N."""
    source: str
    """Where ``typical`` is from."""


def diagonal_parameters(turn: CompliantAxis, shift: CompliantAxis) -> tuple[ParameterSpec, ...]:
    """Return the six parameters, rotations first."""
    specs = []
    for symbol in AXES:
        give, unit = (turn, "rad/(N·m)") if symbol[0] == "r" else (shift, "m/N")
        meaning = give.meaning.format(axis=symbol[1])
        specs.append(ParameterSpec(symbol, unit, meaning, 0.0, give.upper, give.typical, give.source, compliance=True))
    return tuple(specs)


def diagonal_terms(node: int, loads: NodeLoads) -> tuple[Term, ...]:
    """Return δ = diag(tx, ty, tz, rx, ry, rz) w at a node."""
    return tuple(Term(node, axis, symbol, loads.wrench[node, axis]) for symbol, axis in AXES.items())

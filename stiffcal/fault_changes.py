"""The change of the input that would mend a fault, as values: texts are made from it, programs and tests read it."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class InputChange:
    """A change of the input with which the data agree."""

    kind: str
    """What is changed: the name of a mistake (`stiffcal/mistakes/catalogue`), of a plan "runs" or "repeats"."""
    names: tuple[str, ...] = ()
    """Joints, columns, units, targets, axes or runs that it is about, in their order after the change; of rows in
    another order what moves: positions, displacements or loads.
    """
    sizes: tuple[float, ...] = ()
    """By how much, where there is an amount: a zero of each joint, rad (m of a prismatic joint); of a frame three
    angles of a rotation vector, rad, and three lengths, m; of a target three lengths, m; the factor of an angle that is
    added, of a length or a load; the rows by which columns move down, none where they are reversed; an entry of a robot
    file; a number of runs.
    """
    value: str = ""
    """What the manifest or the robot file holds after it: a unit, a convention, or who the load acts on; the key of an
    entry, the axis of a length or the target of axes, where not all are meant.
    """

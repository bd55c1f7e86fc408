"""A robot's compensation as Structured Text: `code_templates/step.st` with the robot's numbers in it."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.compensation.exports.code_words import LINE, filled, identifier, shared_words, wrapped
from stiffcal.compensation.exports.controller_model import ControllerModel
from stiffcal.compensation.exports.law_tables import law_tables, spring_rows
from stiffcal.model.scalar_laws import LawForm

# Stands for infinity; within the range of REAL too, which some compilers hold constants to.
ENDLESS = 1e30
_FORMS = (
    LawForm.POLYNOMIAL, LawForm.CLIPPED, LawForm.POSITIVE, LawForm.CROSSING, LawForm.PLAY, LawForm.PERIODIC,
    LawForm.CUBIC_TORQUE,
)  # fmt: skip
"""In the order of the template's CASE."""


def st_source(model: ControllerModel, head: Sequence[str], stem: str) -> str:
    """Return the file: two types, a function and a function block.

    Parameters
    ----------
    model : the numbers.
    head : lines of the comment at the head, not yet escaped.
    stem : name of the file without ending; names begin with it.
    """
    tables, springs = law_tables(model), spring_rows(model)
    node_of = {int(joint): node for node, joint in enumerate(model.joint) if joint >= 0}
    of_balancers = [(node_of[spring.joint - 1], spring.joint - 1) for spring in model.springs]
    in_balancers = [(*spring.anchor, *spring.arm, spring.rate, spring.free_length) for spring in model.springs]
    of_laws = [(_FORMS.index(law.form), law.joint, law.first, law.count, law.memory) for law in tables.laws]
    in_laws = [law.numbers for law in tables.laws]
    words = shared_words(model, tables, len(springs), number, _numbers, ENDLESS) | {
        "HEAD": "\n".join(wrapped(head)),
        "PREFIX": identifier(stem),
        "HASH_1": model.hash[:32],
        "HASH_2": model.hash[32:],
        "LAST_JOINT": str(len(model.coupling) - 1),
        "LAST_LOGGED": str(model.coupling.shape[1] - 1),
        "LAST_NODE": str(len(model.fixed) - 1),
        "LAST_COMPONENT": str(6 * len(model.fixed) - 1),
        "LAST_MEMORY": str(max(tables.n_memories, 2) - 1),
        "LAST_SPRING": str(max(len(springs), 1) - 1),
        "LAST_LAW": str(max(len(tables.laws), 1) - 1),
        "LAST_WEIGHT": str(max(len(tables.weights), 1) - 1),
        "LAST_BALANCER": str(max(len(model.springs), 1) - 1),
        "DEFORMED": _truth(model.deformed),
        "MOMENTS": _truth(model.moments),
        "READING_AXES": _reading_axes(model.axes_node),
        "JOINT": _list(str(int(joint)) for joint in model.joint),
        "SPRING_TO": _list([str(to) for to, _, _ in springs] or ["0"]),
        "SPRING_FROM": _list([str(source) for _, source, _ in springs] or ["0"]),
        "SPRING_C": _numbers(np.array([c for _, _, c in springs] or [0.0])),
        "LAW": _list(str(entry) for row in of_laws or [(0,) * 5] for entry in row),
        "LAW_NUMBERS": _numbers(np.clip(np.array(in_laws or [(0.0,) * 5]), -ENDLESS, ENDLESS)),
        "WEIGHT_AT": _list([str(index) for index, _ in tables.weights] or ["0"]),
        "WEIGHT": _numbers(np.array([factor for _, factor in tables.weights] or [0.0])),
        "BALANCER": _list(str(entry) for row in of_balancers or [(0, 0)] for entry in row),
        "BALANCER_NUMBERS": _numbers(np.array(in_balancers or [(0.0,) * 8])),
    }  # fmt: skip
    return filled("step.st", words)


def number(value: float) -> str:
    """Return a number as the standard writes it, with a point; it reads back as the same double.

    Examples
    --------
    >>> number(1e-05), number(-0.0), number(2.5e300), number(-3.0)
    ('1.0E-05', '0.0', '2.5E+300', '-3.0')
    """
    mantissa, mark, exponent = repr(float(value) + 0.0).partition("e")
    return (mantissa if "." in mantissa else f"{mantissa}.0") + (f"E{exponent}" if mark else "")


def _truth(value: bool) -> str:
    return "TRUE" if value else "FALSE"


def _reading_axes(node: int) -> str:
    if node < 0:
        return "axes[ii, jj] := axes_there[ii, jj]; (* fixed to the ground *)"
    terms = [f"after_r[0, {node}, ii, {k}] * axes_there[{k}, jj]" for k in range(3)]
    return "axes[ii, jj] := " + ("\n" + 20 * " " + "+ ").join(terms) + ";"


def _numbers(values: Floats) -> str:
    return _list(number(value) for value in np.asarray(values).ravel())


def _list(entries: Iterable[str]) -> str:
    lines = [""]
    for entry in entries:
        if len(lines[-1]) + len(entry) > LINE:
            lines.append("")
        lines[-1] += f" {entry}," if lines[-1] else f"{entry},"
    return "[" + ("\n" + 8 * " ").join(lines).removesuffix(",") + "]"

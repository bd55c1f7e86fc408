"""The text of an effect that tests a pattern of the remainder: what `stiffcal effects new` writes."""

from __future__ import annotations

from string import Template

from stiffcal.diagnosis.answers.pattern_results import CompliancePattern, FollowedBy
from stiffcal.diagnosis.remainder.patterns import ORDERS
from stiffcal.diagnosis.words import what_is_followed

_HEAD = Template('''"""An effect to test: the compliance of a joint follows the $followed."""

import numpy as np

from stiffcal.effects_api import $imports


class $class_name(Law):
    """A joint's compliance follows the $followed: $law.

    Found by `stiffcal diagnose` at joint $joint, where nothing in the catalogue accounted for the remainder.
    Replace the law where you know the cause: which part turns, wears or closes there?

    Assumes that nothing but the $followed changes the compliance.

    Limits: the law holds within what was measured; it is no physics yet.
    """

    name = "$name"
    place_kind = "joints"
    summary = "the joint's compliance follows the $followed"
    parameters = (
        ParameterSpec("a", "rad/(N·m)", "$meaning_a", -1.0, 1.0, $typical, "diagnose"),$second_parameter$order
    )
    fingerprint = "the residual is proportional to the joint's torque, with a factor that the $followed sets"
    how_to_check = "Repeat one load on the joint while the $followed changes and all else stays."

    def terms(self, place, chain, loads, shape):
        """$law."""
        joint = place.joints[0]
        torque = drive_torque(chain, loads.wrench, joint)
        $value
        return (
            *drive_terms(chain, joint, "a", $first * torque),$second_term
        )
$methods''')
_SECOND_PARAMETER = """
        ParameterSpec("b", "rad/(N·m)", "{meaning}", -1.0, 1.0, {typical}, "diagnose"),"""
_SECOND_TERM = """
            *drive_terms(chain, joint, "b", {second} * torque),"""
_ORDER = """
        ParameterSpec("order", "1", "waves per turn", {low}, {high}, {typical}, "diagnose", ParameterRole.NONLINEAR),"""
_GRID = '''
    def nonlinear_grid(self, place, chain, loads):
        """Orders to start from."""
        return {{"order": np.arange({low}, {high} + 0.01, {step})}}
'''
_COVARIATE = '''
    def covariate(self, place, chain, loads):
        """The $followed."""
        $value
        return Covariate("$followed", "$unit", $drawn)
'''


def plugin_text(pattern: CompliancePattern, name: str) -> str:
    """Return a Python file with an effect of the law that a pattern supports.

    Parameters
    ----------
    pattern : as `diagnose` found it.
    name : of the effect, lower case with hyphens.
    """
    values = {parameter.symbol: parameter.value or 0.0 for parameter in pattern.parameters}
    typical = max(abs(value) for symbol, value in values.items() if symbol in ("a", "b"))
    angle, motion = pattern.follows is FollowedBy.JOINT_ANGLE, pattern.follows is FollowedBy.LAST_MOTION
    names = ["Covariate", "Law", "ParameterSpec", "drive_terms", "drive_torque"]
    names += ["ParameterRole"] if angle else ["tool_node"] if pattern.follows is FollowedBy.LOAD else []
    meaning_b = "sine part of the compliance" if angle else "quadratic part of the compliance"
    fields = {
        "followed": what_is_followed(pattern),
        "imports": ", ".join(sorted(names)),
        "class_name": "".join(word.capitalize() for word in name.split("-")),
        "name": name,
        "joint": str(pattern.joint),
        "law": "δ_Rz = (a cos mq + b sin mq) τ" if angle else "δ_Rz = a s τ" if motion else "δ_Rz = (a s + b s²) τ",
        "meaning_a": "cosine part of the compliance" if angle else "linear part of the compliance",
        "typical": f"{typical:.3g}",
        "order": _ORDER.format(low=ORDERS[0], high=ORDERS[-1], typical=f"{values['order']:.3g}") if angle else "",
        "value": _value(pattern),
        "first": "np.cos(phase)" if angle else "s",
        "second_parameter": "" if motion else _SECOND_PARAMETER.format(meaning=meaning_b, typical=f"{typical:.3g}"),
        "second_term": "" if motion else _SECOND_TERM.format(second="np.sin(phase)" if angle else "s**2"),
    }
    covariate = {
        "followed": fields["followed"],
        "value": _value(pattern) if not angle else f"angle = loads.angles[{(pattern.of_joint or 1) - 1}]",
        "unit": "rad" if angle else "1",
        "drawn": "angle" if angle else "s",
    }
    grid = _GRID.format(low=ORDERS[0], high=ORDERS[-1], step=float(ORDERS[1] - ORDERS[0])) if angle else ""
    text = _HEAD.substitute(fields, methods=grid + Template(_COVARIATE).substitute(covariate))
    return text if "np." in text else text.replace("import numpy as np\n\n", "")


def _value(pattern: CompliancePattern) -> str:
    """Return the line that computes what the compliance follows."""
    joint, scale = pattern.of_joint or 0, f"{pattern.scale:.6g}"
    return {
        FollowedBy.JOINT_ANGLE: f'phase = shape["order"] * loads.angles[{joint - 1}]',
        FollowedBy.JOINT_TORQUE: f"s = np.abs(drive_torque(chain, loads.wrench, {joint})) / {scale}",
        FollowedBy.LOAD: f"s = np.linalg.norm(loads.wrench[tool_node(chain), :3], axis=0) / {scale}",
        FollowedBy.TIME: f"s = 0.0 * loads.angles[0] if loads.order is None else loads.order.time / {scale}",
        FollowedBy.LAST_MOTION: (
            f"s = 0.0 * loads.angles[0] if loads.order is None else loads.order.direction({joint}) * "
            f"np.sign(drive_torque(chain, loads.wrench, {joint}))"
        ),
    }[pattern.follows]

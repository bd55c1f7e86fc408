"""Friction of the drives as it is shown: a table, and torque over velocity for every joint (004, Fig. 4)."""

from __future__ import annotations

from collections.abc import Sequence

from stiffcal.errors import InputError
from stiffcal.estimate import Estimate
from stiffcal.fault_codes import FaultCode
from stiffcal.identification.answers.fit_results import IdentifiedParameter
from stiffcal.kinds.friction.answers.curves import FrictionCurve, friction_curves, unused_passes
from stiffcal.kinds.friction.answers.parts import friction_evidence, friction_readings
from stiffcal.kinds.friction.answers.pictures import friction_picture
from stiffcal.kinds.friction.answers.results import BearingFriction, FrictionSection
from stiffcal.kinds.measured import MeasuredRuns
from stiffcal.kinds.results import IdentifiedModel
from stiffcal.presentation.values import Block, Column, Listing, Overview, Page, Plot, Sentence, Table
from stiffcal.presentation.words import Digits, Words
from stiffcal.wording import AT_LIMIT

_TITLE = "Friction of the drives"
_PER_PICTURE = 3
_SYMBOLS = ("coulomb", "viscous", "stribeck", "velocity", "exponent")
# The effects whose symbols these are; those of others stand in a table of their own.
_TABLED = ("joint-friction", "stribeck")


def friction_overview(section: FrictionSection, identified: IdentifiedModel) -> Overview:
    """Return coulomb, viscous and Stribeck terms joint by joint, and of which the runs show nothing.

    Parameters
    ----------
    section : of ``identify``. identified : the whole answer.
    """
    laws, joints = set(section.effects or ()), {joint.joint for joint in section.joints}
    friction_parameters = [
        parameter for parameter in identified.parameters if parameter.effect in laws and _joint_of(parameter) in joints
    ]
    by_name = {(_joint_of(parameter), _symbol_of(parameter)): parameter for parameter in friction_parameters}
    rows: list[tuple[Words, ...]] = []
    stribeck_rows: list[tuple[Words, ...]] = []
    more_rows: list[tuple[Words, ...]] = []
    for joint in section.joints:
        number, name = joint.joint, f"joint {joint.joint} ({joint.name})"
        speeds: Words = (Digits(joint.lowest_speed), " … ", Digits(joint.highest_speed))
        cells = {symbol: _value_cell(by_name.get((number, symbol))) for symbol in _SYMBOLS}
        rows.append(((name,), cells["coulomb"], cells["viscous"], speeds, (Digits(joint.rms),)))
        if (stribeck := by_name.get((number, "stribeck"))) is not None and stribeck.value is not None:
            stribeck_rows.append(((name,), cells["stribeck"], cells["velocity"], cells["exponent"]))
        more_rows += [
            (
                (name,),
                (parameter.effect,),
                (parameter.name.rsplit(".", 1)[-1],),
                _value_cell(parameter),
                (parameter.unit,),
            )
            for parameter in friction_parameters
            if _joint_of(parameter) == number and parameter.effect not in _TABLED
        ]
    parameters = frozenset(parameter.name for parameter in friction_parameters)
    if not rows:
        return Overview((), parameters=parameters)
    blocks: list[Sentence | Table] = [Table(_OVERVIEW_COLUMNS, tuple(rows))]
    if stribeck_rows:
        blocks.append(Table(_STRIBECK_COLUMNS, tuple(stribeck_rows)))
    if more_rows:
        blocks.append(Table(_MORE_COLUMNS, tuple(more_rows)))
    blocks += reference_sentences(section, friction_parameters)
    blocks += [_bearing_sentence(bearing) for bearing in section.bearings or ()]
    return Overview(tuple(blocks), parameters=parameters)


_OVERVIEW_COLUMNS = (
    Column("friction of", numbers=False),
    Column("coulomb", "N·m"),
    Column("viscous", "N·m·s/rad"),
    Column("speeds", "rad/s"),
    Column("residual, rms", "N·m"),
)
_STRIBECK_COLUMNS = (
    Column("crawling", numbers=False),
    Column("stribeck", "N·m"),
    Column("velocity", "rad/s"),
    Column("exponent"),
)


def reference_sentences(section: FrictionSection, parameters: Sequence[IdentifiedParameter]) -> list[Sentence]:
    """Return from which temperature the effects of temperature count, for joints that have some."""
    texts = []
    for joint in section.joints:
        warm = any(p.unit.endswith(("/K", "K)")) and _joint_of(p) == joint.joint for p in parameters)
        if warm and joint.reference_temperature is not None:
            celsius = joint.reference_temperature - 273.15
            text: Words = (
                f"joint {joint.joint}: temperatures count from ",
                Digits(celsius),
                " °C, the first logged value",
            )
            texts.append(Sentence(text, "reference-temperature"))
    return texts


_MORE_COLUMNS = (
    Column("in addition", numbers=False),
    Column("effect", numbers=False),
    Column("parameter", numbers=False),
    Column("value"),
    Column("unit", numbers=False),
)


def _joint_of(parameter: IdentifiedParameter) -> int:
    return (parameter.where.joints or [0])[0]


def _symbol_of(parameter: IdentifiedParameter) -> str:
    return parameter.name.rsplit(".", 1)[-1]


def _value_cell(parameter: IdentifiedParameter | None) -> Words:
    """Return a value with its 95 % interval, or "(fixed)" where the model file fixes it; a dash where there is none."""
    if parameter is None or parameter.value is None:
        return (Digits(None),)
    if parameter.interval is None:
        return (Digits(parameter.value), " (fixed)") if parameter.fixed else (Digits(parameter.value),)
    low, high = parameter.interval
    if low is None or high is None:
        return (Digits(parameter.value), f" ({AT_LIMIT})")
    return (Estimate(value=parameter.value, interval=[low, high]),)


def _bearing_sentence(bearing: BearingFriction) -> Sentence:
    terms = []
    for value, std in ((bearing.coulomb, bearing.coulomb_std), (bearing.viscous, bearing.viscous_std)):
        terms.append(Estimate.of(value, std))
    text: Words = (
        f"joint {bearing.joint}: the shaft of its drive also rotates with other joints; the bearing of the joint adds ",
        terms[0], " N·m and ", terms[1], " N·m·s/rad",
    )  # fmt: skip
    return Sentence(text, "bearing-friction")


def friction_page(data: MeasuredRuns, section: FrictionSection, identified: IdentifiedModel) -> Page:
    """Return the law, its parameters, and the curves.

    Parameters
    ----------
    data : the campaign, with the fit's rows among its tables.
    section : of ``identify``. identified : the whole answer.
    """
    curves = friction_curves(data, section, identified)
    unused = unused_passes(friction_readings(data)[0])
    if not curves:
        why = "the friction runs contain no usable reading"
        return Page(_TITLE, (), subject=_SUBJECT, why_empty=why, unused=unused)
    blocks: list[Block] = [Sentence((_law_words(curves),), "law"), _table(curves)]
    blocks += reference_sentences(section, identified.parameters)
    remarks = [Sentence((f"{curve.joint}: {text}",), "not-identified") for curve in curves for text in curve.remarks]
    if remarks:
        blocks += [Sentence(("Not identifiable from these runs:",), "not-identified"), Listing(tuple(remarks))]
    blocks += [friction_picture(curves[start : start + _PER_PICTURE]) for start in range(0, len(curves), _PER_PICTURE)]
    blocks += friction_evidence(data)
    return Page(
        _TITLE,
        tuple(blocks),
        subject=_SUBJECT,
        subject_of_model="Friction of the drives",
        fitted=f"Friction of {len(curves)} {'drive' if len(curves) == 1 else 'drives'}",
        parameters=_parameters(section, identified),
        unused=unused,
    )


_SUBJECT = "friction in free motion"


def friction_plot(
    data: MeasuredRuns, section: FrictionSection | None, identified: IdentifiedModel, joint: str | None
) -> Plot:
    """Return friction over speed of every joint, or of one by its name.

    Raises
    ------
    InputError
        No friction was measured, or not of this joint.
    """
    curves = () if section is None else friction_curves(data, section, identified)
    if not curves:
        mend = "measure friction runs, or plot another quantity"
        raise InputError.at(
            FaultCode.DATA_MISSING, str(data.campaign.folder), "runs", "this campaign contains no friction runs", mend
        )
    drawn = tuple(curve for curve in curves if joint in (None, curve.joint))
    if not drawn:
        raise InputError.at(
            FaultCode.DATA_MISSING,
            "command line",
            "--against",
            f"joint {joint} has no friction runs",
            f"choose velocity:{curves[0].joint}, say",
        )
    names = ", ".join(curve.joint for curve in drawn)
    return Plot(friction_picture(drawn), f"friction over speed of {names}")


def _parameters(section: FrictionSection, identified: IdentifiedModel) -> frozenset[str]:
    """Return the names of the parameters that the page shows: those of joints of which anything is known."""
    laws = set(section.effects or ())
    friction_parameters = [parameter for parameter in identified.parameters if parameter.effect in laws]
    known_places = [parameter.where for parameter in friction_parameters if parameter.value is not None]
    return frozenset(parameter.name for parameter in friction_parameters if parameter.where in known_places)


def _law_words(curves: tuple[FrictionCurve, ...]) -> str:
    text = (
        "Friction torque at a velocity ω, at the joint's side of the gear: (coulomb + stribeck · exp(−(|ω| / velocity)^"
        "exponent)) · sign ω + viscous · ω (Lehmann et al. 2013, eq. 1), stribeck if the model contains it. "
    )
    if any(curve.steady for curve in curves):
        text += (
            "Velocities as logged, in both directions; half the difference of the two directions over the same range "
            "of angle is free of weight. "
        )
    if not all(curve.steady for curve in curves):
        text += (
            "Without phases of constant velocity, weight and inertia of the moving links were fitted together "
            "with the friction. "
        )
    return text.strip()


def _table(curves: tuple[FrictionCurve, ...]) -> Table:
    columns = (
        Column("joint", numbers=False),
        Column("coulomb", "N·m"),
        Column("viscous", "N·m·s/rad"),
        Column("stribeck", "N·m"),
        Column("velocity", "rad/s"),
        Column("exponent"),
        Column("residual, rms", "N·m"),
        Column("noise", "N·m"),
    )
    rows: list[tuple[Words, ...]] = []
    for curve in curves:
        value_and_half = {symbol: (value, half) for symbol, value, half, _ in curve.parameters}
        cells: list[Words] = []
        for symbol in _SYMBOLS:
            value, half = value_and_half.get(symbol, (None, None))
            if value is None:
                cells.append((Digits(None),))
            else:
                cells.append(
                    (Digits(value), " (fixed)")
                    if half is None
                    else (Estimate(value=value, interval=[value - half, value + half]),)
                )
        rows.append(((curve.joint,), *cells, (Digits(curve.rms),), (Digits(curve.noise),)))
    return Table(
        columns,
        tuple(rows),
        "Friction of the drives, ± 95 %. What is not in the model, or not identified, has no value.",
    )

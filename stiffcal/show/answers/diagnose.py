"""What `diagnose` shows: what is missing and how probable, what looks the same, the ranking, what would decide."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from stiffcal.presentation.bars import bar
from stiffcal.presentation.values import Column
from stiffcal.quantity import JOINT_ANGLE, quantity_of
from stiffcal.results.value_words import value_with_unit
from stiffcal.show import parts
from stiffcal.show.before_after import add_moved
from stiffcal.show.builder import PageBuilder, number, roomy
from stiffcal.show.effects import diagnosis_level, effect_words, look_alike_words, place_words
from stiffcal.show.excluded import excluded_in_words, places_without_effect, size_words
from stiffcal.validation.schemes import held_out, held_out_by_diagnosis
from stiffcal.wording import (
    DASH,
    count,
    deviation,
    explained_in_words,
    length,
    listing,
    place,
    place_label,
    probability_in_words,
    share,
    significant,
    variable,
)

if TYPE_CHECKING:
    from stiffcal.diagnosis.answers.results import DiagnoseResult, ProposedEffect, UnknownLaw
    from stiffcal.presentation.pictures import Picture
    from stiffcal.presentation.values import Page
    from stiffcal.show.options import ShowOptions

MOST_ROWS = 8
"""Rows of the ranking without details."""
MOST_DESCRIBED = 2
"""Missing effects that are described one by one without details."""
BAR = 10
"""Characters of a bar of probability."""
EXPLAINS = (
    "explains: share of the error above the noise that goes, of what alone is missing by the refitted model, of all "
    "others by a first estimate of the values"
)
PROBABILITY = "probability: that it is there, next to all other effects, mistakes in the data and laws of no catalogue"
AT_TOOL = "size: rms of its displacement at the tool, or of its torque"


def page(result: DiagnoseResult, options: ShowOptions) -> Page:
    """Return the answer first, then the evidence and what is probable.

    With details there are also the whole ranking, what adding would change, how to check on the machine, and what was
    not tried.
    """
    made = PageBuilder("Missing effects")
    made.say(result.summary, "verdict", diagnosis_level(result))
    _add_with_all_missing(made, result)
    made.add(parts.registration(result.registration))
    made.add(parts.suspects(result.suspects, result.suspects_not_checked, searched=True))
    if result.with_suspects is not None:
        effect_names = ", ".join(effect_words(effect) for effect in result.with_suspects.missing) or "nothing"
        unexplained = "; part of the error is unexplained" if result.with_suspects.unexplained else ""
        made.say(f"including them the result would be: missing: {effect_names}{unexplained}", "with-suspects")
    if options.details or len(result.missing) <= MOST_DESCRIBED:
        for effect in result.missing:
            add_missing(made, result, effect, options.details)
    else:
        made.head("missing:")
        made.list((f"{effect_words(one)}{_sure_words(one)}{_alike(one)}" for one in result.missing), "missing")
    if not all(effect.firm for effect in result.missing):
        made.say("improve adds what is not certain when asked, or with --likely", "not-certain")
    picture = followed_picture(result, options) or law_picture(result)
    if picture is not None:
        made.draw(picture)
    if options.details:
        names = ", ".join(effect_words(effect) for effect in result.missing)
        add_moved(made, result.before_after, f"what adding {names} would change")
    add_in_model(made, result)
    add_rest(made, result, options)
    _add_ranking(made, result, options.details)
    _add_next_measurement(made, result, options)
    if options.details:
        _add_pace(made, result)
        _add_not_tried(made, result)
    else:
        _add_what_details_show(made, result)
    return made.page()


def add_rest(made: PageBuilder, result: DiagnoseResult, options: ShowOptions) -> None:
    """Add what cannot be excluded, what cannot be distinguished or is not needed, and what the rest follows."""
    _add_excluded(made, result, options)
    if result.could_be:
        made.head("cannot be distinguished in these poses and loads:")
        which = [f"{candidate.effect}: {place(candidate.where)}" for candidate in result.could_be]
        made.list([*which, "measure more poses, or the same poses with loads along other axes"], "could-be")
    if result.superfluous:
        made.head("not needed, in the model and probably not there:")
        lines = []
        for one in result.superfluous:
            line = options.line("remove", one.effect, *place_words(one.where))
            lines.append(f"{effect_words(one)}; to remove: {line}")
        lines.append("that these data cannot distinguish it from zero does not show that it is zero")
        made.list(lines, "not-needed")
    if result.structure:
        made.head("the remaining error depends on:")
        made.list(
            [f"{variable(one.follows)} ({share(one.share)} of it): {one.seen}" for one in result.structure], "rest"
        )


def followed_picture(result: DiagnoseResult, options: ShowOptions) -> Picture | None:
    """Return the residual over what it follows; None where there is nothing to show, or no campaign is known."""
    if options.folder is None:
        return None
    from stiffcal.presentation.pictures import scattered
    from stiffcal.stages.diagnoses.followed import followed_residual
    from stiffcal.stages.steps import RunContext

    found = followed_residual(options.folder, result, RunContext(store=options.store))
    if found is None:
        return None
    x_label, y_label = _titled(found.follows, found.follows_unit), _titled(found.of, found.unit)
    return scattered(found.x, found.y, x_label, y_label)


def law_picture(result: DiagnoseResult) -> Picture | None:
    """Return the most probable law that no catalogue holds, where it is probable and has a curve."""
    law: UnknownLaw | None = next(iter(result.unknown or ()), None)
    if law is None or law.curve is None or not result.unexplained:
        return None
    import numpy as np

    from stiffcal.presentation.pictures import scattered

    unit = quantity_of(law.curve.value_unit).unit_for(law.curve.value)
    over = (JOINT_ANGLE if law.curve.unit == "rad" else quantity_of(law.curve.unit)).unit_for(law.curve.at)
    what, _, joint = law.curve.over.partition(":")
    at, value = over.factor * np.array(law.curve.at), unit.factor * np.array(law.curve.value)
    x_label = _titled(f"{what} of joint {joint}", over.name)
    return scattered(at, value, x_label, _titled(f"law of {law.of} that no catalogue holds", unit.name))


def _titled(label: str, unit: str) -> str:
    return f"{label} [{unit}]" if unit else label


def _add_with_all_missing(made: PageBuilder, result: DiagnoseResult) -> None:
    """Add the error with several missing effects together: each row of the ranking adds only one."""
    if len(result.missing) < 2 or result.heldout_rms_with_missing is None:
        return
    names = "all that is missing"
    if len(result.missing) <= MOST_DESCRIBED:
        placed = (effect_words(effect) if dict(effect.where.items()) else effect.effect for effect in result.missing)
        names = listing(placed)
    noise = deviation(result.noise) if result.noise else "not known"
    left = f"{deviation(result.heldout_rms_with_missing)} in {held_out_by_diagnosis(result.heldout_rms_with_missing)}"
    validated = result.as_validated
    if validated is not None and validated.with_missing is not None:
        left += f", {deviation(validated.with_missing)} in {held_out(validated.scheme)}"
    made.say(f"with {names}: {left}, noise {noise}", "with-missing")


def add_missing(made: PageBuilder, result: DiagnoseResult, effect: ProposedEffect, details: bool = False) -> None:
    """Add an effect that is missing: how probable it is, what looks the same, what was seen, its refitted values."""
    made.head(f"missing: {effect_words(effect)}{_sure_words(effect)}")
    texts = []
    if effect.alternatives:
        names = ", ".join(look_alike_words(effect, alternative) for alternative in effect.alternatives)
        texts.append(f"cannot be distinguished from: {names}")
    finding = result.finding_of(effect)
    # found next to another effect: the ranking explains additions to the present model alone
    explanation = None if finding is None else finding.evidence
    if explanation is not None:
        texts += [explanation.seen, *[explanation.means] * details]
    if details or len(result.missing) == 1:
        texts += _refitted(result, effect)
    if explanation is not None and details:
        alike = "" if effect.alternatives else explanation.alike  # those are named above, each with how alike it is
        texts += [text for text in (alike, explanation.check) if text]
    made.list(texts, "missing")


def _sure_words(effect: ProposedEffect) -> str:
    """Return how sure the diagnosis is of an effect."""
    certain = "certain" if effect.firm else "not certain"
    group, own = (probability_in_words(p or 0.0) for p in (effect.probability, effect.probability_of(effect)))
    if not effect.alternatives:
        return f": {group}, {certain}"
    return f": {group} that it or one of those below is, {own} that it is, {certain}"


def _refitted(result: DiagnoseResult, effect: ProposedEffect) -> list[str]:
    """Return an effect's values with all that is missing in the model, which `improve` writes."""
    texts = []
    for value in result.before_after:
        if value.before is None and value.effect == effect.effect and value.where == effect.where:
            unit = value.quantity.unit_for([value.after.value if value.after else None])
            texts.append(f"{value.name.rpartition('.')[2]} {value_with_unit(value.after, unit)}")
    everything = "all that is missing" if len(result.missing) > 1 else "it"
    return [f"Refitted with {everything}, ± 95 %: {', '.join(texts)}."] if texts else []


def add_in_model(made: PageBuilder, result: DiagnoseResult) -> None:
    """Add how sure it is that the effects of the model are there, and what looks the same."""
    for effect in result.in_model or ():
        p = probability_in_words(effect.probability or 0.0)
        made.say(f"in the model: {effect_words(effect)}: {p}{_alike(effect)}", "in-model")


def _alike(effect: ProposedEffect) -> str:
    """Return what an effect cannot be distinguished from, as the end of a sentence."""
    names = ", ".join(look_alike_words(effect, other) for other in effect.alternatives)
    return f"; cannot be distinguished from: {names}" if names else ""


def _add_excluded(made: PageBuilder, result: DiagnoseResult, options: ShowOptions) -> None:
    """Add how large an effect at each place would have been found, where nothing is, and what load would decide."""
    for k, text in enumerate(excluded_in_words(result, options.details)):
        made.say(text, "excluded", starts_paragraph=k == 0)
    sizes = places_without_effect(result)
    forces = sorted(((one.deciding_force_N, one.of) for one in sizes if one.deciding_force_N is not None), reverse=True)
    if forces:
        needed = ", ".join(f"{significant(force)} N ({of})" for force, of in forces)
        line = options.line("plan", "--force", f"{math.ceil(forces[0][0])}")
        text = f"to find an effect as large as the noise, load with up to {needed}; to plan it: {line}"
        made.say(text, "deciding-load")


def _add_ranking(made: PageBuilder, result: DiagnoseResult, details: bool) -> None:
    """Add the ranking for the next single step, without details the first of what is not rejected alone."""
    probable = [finding for finding in result.findings if finding.verdict != "rejected"]
    shown = result.findings if details else probable[:MOST_ROWS]
    if not shown:
        return
    left_out = held_out_by_diagnosis(result.rms)
    explains, size = number("explains"), number("size")
    columns = (
        "effect", "place", number("probability"), number(f"{left_out}, rms"), "verdict",
        explains if details else roomy(explains), size if details else roomy(size), roomy(Column("", numbers=False)),
    )  # fmt: skip
    rows = [("present model", "", "", deviation(result.rms), "", "", "", "")]
    for finding in shown:
        p = finding.probability or 0.0
        rows.append(
            (
                finding.effect,
                place_label(finding.where),
                probability_in_words(p),
                deviation(finding.heldout_rms_after),
                finding.verdict,
                explained_in_words(result.explained_by(finding)),
                size_words(finding.size_m, finding.size_Nm),
                bar(BAR * p, None, BAR),
            )
        )
    rows.append(("noise", "", "", deviation(result.noise) if result.noise else DASH, "", "", "", ""))
    made.head("each effect added to the present model by itself:")
    made.table(columns, rows)
    validated = result.as_validated
    if validated is not None and held_out(validated.scheme) != left_out:
        other = f"the error in {held_out(validated.scheme)}, {deviation(validated.rms)}"
        made.list([f"{left_out}: each left out by itself; {other}, is what validate and improve show"], "held-out")
    made.list(_found_later(result), "found-later")
    if details:
        explained = any(finding.explains is not None for finding in result.findings)
        made.list([*[EXPLAINS] * explained, f"{PROBABILITY}; {AT_TOOL}"], "columns")


def _found_later(result: DiagnoseResult) -> list[str]:
    """Explain rows whose verdict is not the answer's: judged next to another effect, or significant and too small."""
    from stiffcal.diagnosis.answers.results import supported_but_not_named

    texts = []
    ranked = [(effect, result.finding_of(effect)) for effect in result.missing]
    later = [effect_words(effect) for effect, finding in ranked if finding is None or finding.verdict != "supported"]
    first = [
        effect_words(effect) for effect, finding in ranked if finding is not None and finding.verdict == "supported"
    ]
    if later and first:
        text = f"each row adds one effect to the present model; {', '.join(later)} was found after adding "
        text += ", ".join(first)
        if len(first) == 1 and result.heldout_rms_with_missing is not None:
            (before,) = (found.heldout_rms_after for _, found in ranked if found and found.verdict == "supported")
            text += f": {deviation(before)} in {held_out_by_diagnosis(result.rms)} becomes "
            text += deviation(result.heldout_rms_with_missing)
        texts.append(text)
    not_named = supported_but_not_named(result)
    if not_named is not None:
        text = f"{effect_words(not_named)} lowers the error significantly and is not named: the rest has no explanation"
        texts.append(text)
    return texts


def _add_next_measurement(made: PageBuilder, result: DiagnoseResult, options: ShowOptions) -> None:
    measurement = result.next_measurement
    if measurement is not None:
        pose = ", ".join(significant(value) for value in measurement.pose_deg)
        load = ", ".join(significant(value) for value in measurement.load[:3])
        between = " and ".join(effect_words(effect) for effect in measurement.separates)
        made.say(
            f"to distinguish {between}: pose ({pose})°, force ({load}) N in the axes in which forces are logged; "
            f"predicted difference {length(measurement.difference_m)}",
            "next-measurement",
            starts_paragraph=True,
        )
        words = None if options.folder is None else _plan_words(measurement.load, options)
        if words is not None:
            line = options.line("plan", "--for", "look-alikes", *words)
            made.say(f"to plan runs that decide: {line}", "next-measurement")
    elif len(result.missing) == 1 and result.missing[0].alternatives and result.rms.torque is None:
        made.say(
            "no load of this campaign's size, in any one pose, separates the two leading look-alikes by more than "
            "the noise",
            "next-measurement",
            starts_paragraph=True,
        )


def _plan_words(load: list[float], options: ShowOptions) -> tuple[str, ...] | None:
    """Return the options of a plan with such a load; None where none can be made."""
    from stiffcal.stages.plans.plannable import plannable_words
    from stiffcal.stages.steps import RunContext

    if options.folder is None:
        return None
    return plannable_words(options.folder, math.ceil(math.hypot(*load[:3])), RunContext(store=options.store))


def _add_pace(made: PageBuilder, result: DiagnoseResult) -> None:
    pace = result.pace
    if pace.candidates == 0:
        return
    left = (
        ""
        if result.not_weighed is None
        else "; combinations of these with one effect more, which have about "
        f"{share(result.not_weighed)} of the probability, were not compared"
    )
    shapes = "" if pace.signatures == pace.candidates else f" ({pace.signatures} with their shapes)"
    made.say(
        f"compared {pace.candidates} effects at their places{shapes} about "
        f"{pace.models} model{'s' * (pace.models != 1)} in {significant(pace.seconds)} s{left}",
        "pace",
        starts_paragraph=True,
    )


def _add_not_tried(made: PageBuilder, result: DiagnoseResult) -> None:
    """Name the effects of the catalogue that these data cannot test, by what they need."""
    if not result.not_tried:
        return
    made.head("not tried:")
    effects: dict[str, list[str]] = {}
    for untestable in result.not_tried:
        effects.setdefault(untestable.needs, []).append(untestable.effect)
    made.list([f"{', '.join(named)}: needs {needs}" for needs, named in effects.items()], "not-tried")


def _add_what_details_show(made: PageBuilder, result: DiagnoseResult) -> None:
    """Name what stands in the answer and is not shown."""
    if not result.has_searched:
        return
    further = [f"the ranking of all {len(result.findings)} candidates"] * bool(result.findings)
    if result.missing:
        further += ["how to check on the machine", "which values an addition would change"]
    if result.not_tried:
        further.append(f"{count(len(result.not_tried), 'effect')} that these data cannot test")
    if result.not_weighed is not None:
        further.append("what was not compared")
    if further:
        made.say(f"diagnose --details shows {listing(further)}", "more", starts_paragraph=True)

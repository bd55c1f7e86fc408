"""`stiffcal diagnose`: is the model good enough, and if not, which physical effect is missing."""

from __future__ import annotations

import math
from functools import partial
from typing import TYPE_CHECKING

from stiffcal.cli.answers import answering
from stiffcal.cli.before_after import show_moved
from stiffcal.cli.endings import OK
from stiffcal.cli.ladder_bars import bar
from stiffcal.cli.next_step import following
from stiffcal.cli.options import HERE, AsJson, Details, Folder, NoUpdate, StoreAt
from stiffcal.cli.pages import draw_blocks
from stiffcal.cli.tables import plain_table
from stiffcal.cli.verdict import diagnosis_level, show_verdict
from stiffcal.cli.wording import NOT_KNOWN, deviation, length, places, share, short_places, significant
from stiffcal.escapes.shell import command_line
from stiffcal.quantity import JOINT_ANGLE, quantity_of
from stiffcal.results.next_step import Step
from stiffcal.results.value_words import value_with_unit
from stiffcal.show import parts
from stiffcal.validation.schemes import held_out, held_out_by_diagnosis
from stiffcal.wording import count, explained_in_words, listing, probability_in_words, variable

if TYPE_CHECKING:
    from pathlib import Path

    from stiffcal.cli.console import AnswerConsole
    from stiffcal.diagnosis.answers.results import DiagnoseResult, LookAlike, ProposedEffect
    from stiffcal.model.summary import EffectAt, Where
    from stiffcal.stages.diagnoses.followed import FollowedResidual

MOST_ROWS, MOST_PLACES = 8, 4
BAR, ROOMY = 10, 100
"""Columns of a bar of probability, and of a terminal that has room for one."""
EXPLAINS = (
    "explains: share of the error above the noise that goes, of what alone is missing by the refitted model, of all "
    "others by a first estimate of the values"
)

PROBABILITY = "probability: that it is there, next to all other effects, mistakes in the data and laws of no catalogue"
AT_TOOL = "size: rms of its displacement at the tool, or of its torque"


def diagnose(
    folder: Folder = HERE,
    details: Details = False,
    as_json: AsJson = False,
    no_update: NoUpdate = False,
    store: StoreAt = None,
) -> int:
    """Find which physical effect the model lacks.

    Compares every set of effects, mistakes in the data and laws of no catalogue that is worth it, and states how
    probable each effect is, what looks the same, and whether anything is missing; the error in held-out poses shows
    what adding it does.

    Example: stiffcal diagnose demo
    """
    with answering(as_json) as answer:
        from stiffcal.commands.diagnose import diagnose_campaign
        from stiffcal.stages.steps import RunContext

        context = RunContext(store=store, update=not no_update, progress=answer.progress, notify=answer.notify)
        result = diagnose_campaign(folder, context)
        followed = None
        if not as_json:
            from stiffcal.stages.diagnoses.followed import followed_residual

            followed = followed_residual(folder, result, context)
        show = partial(show_diagnosis, folder=folder, store=store, followed=followed, details=details)
        answer.give(result, show, following(folder, store, Step.DIAGNOSE))
    return OK


def place_words(where: Where) -> list[str]:
    """Return the options that name a place.

    Examples
    --------
    >>> from stiffcal.model.summary import Where
    >>> place_words(Where(joints=[4]))
    ['--joints', '4']
    """
    texts = []
    for kind, items in where.items():
        names = ["-".join(str(member) for member in item) if isinstance(item, list) else str(item) for item in items]
        texts += [f"--{kind}", ",".join(names)]
    return texts


def effect_words(effect: EffectAt | ProposedEffect) -> str:
    """Return an effect with its place."""
    return f"{effect.effect} ({places(effect.where)})"


def look_alike_words(of: ProposedEffect, effect: LookAlike) -> str:
    """Return a look-alike with its place and its probability."""
    return f"{effect.effect} ({places(effect.where)}) {probability_in_words(of.probability_of(effect) or 0.0)}"


def show_diagnosis(
    console: AnswerConsole,
    result: DiagnoseResult,
    folder: Path,
    store: str | None,
    followed: FollowedResidual | None,
    details: bool,
) -> None:
    """Draw the answer first, then the evidence and what is probable.

    Parameters
    ----------
    console : where to. result : the diagnosis. folder, store : as they were given, for commands to copy.
    followed : the residual over what it follows; None where there is nothing to show.
    details : also the whole ranking, what adding would change, how to check on the machine, and what was not tried.
    """
    show_verdict(console, diagnosis_level(result.adequate, bool(result.missing)), result.summary)
    _show_with_all_missing(console, result)
    console.show_warnings(result.warnings)
    draw_blocks(console, parts.registration(result.registration))
    draw_blocks(console, parts.suspects(result.suspects, result.suspects_not_checked))
    if result.with_suspects is not None:
        effect_names = ", ".join(effect_words(effect) for effect in result.with_suspects.missing) or "nothing"
        unexplained = "; part of the error is unexplained" if result.with_suspects.unexplained else ""
        console.print(f"including them the result would be: missing: {effect_names}{unexplained}", soft_wrap=True)
    for effect in result.missing:
        _show_missing(console, result, effect, details)
    if followed is not None:
        _show_followed(console, followed)
    else:
        _show_unknown(console, result)
    if details:
        names = ", ".join(effect_words(effect) for effect in result.missing)
        show_moved(console, result.before_after, f"what adding {names} would change")
    _show_in_model(console, result)
    _show_excluded(console, result, folder, store, details)
    if result.could_be:
        console.print("\ncannot be distinguished in these poses and loads:")
        for candidate in result.could_be:
            console.print(f"  {candidate.effect}: {places(candidate.where)}", soft_wrap=True)
        console.print("  measure more poses, or the same poses with loads along other axes")
    if result.superfluous:
        console.print("\nnot needed, in the model and probably not there:")
        for redundant in result.superfluous:
            line = command_line("remove", folder, redundant.effect, *place_words(redundant.where))
            console.print(f"  {effect_words(redundant)}; to remove: {line}", soft_wrap=True)
        console.print("  that these data cannot distinguish it from zero does not show that it is zero")
    if result.structure:
        console.print("\nthe remaining error depends on:")
        for dependence in result.structure:
            console.print(
                f"  {variable(dependence.follows)} ({share(dependence.share)} of it): {dependence.seen}", soft_wrap=True
            )
    _show_ranking(console, result, details)
    _show_next_measurement(console, result, folder, store)
    if details:
        _show_pace(console, result)
        _show_not_tried(console, result)
    else:
        _show_what_details_show(console, result)


def _show_not_tried(console: AnswerConsole, result: DiagnoseResult) -> None:
    """Name the effects of the catalogue that these data cannot test, by what they need."""
    if not result.not_tried:
        return
    console.print("\nnot tried:")
    effects: dict[str, list[str]] = {}
    for untestable in result.not_tried:
        effects.setdefault(untestable.needs, []).append(untestable.effect)
    for needs, named in effects.items():
        console.print(f"  {', '.join(named)}: needs {needs}", soft_wrap=True)


def _show_what_details_show(console: AnswerConsole, result: DiagnoseResult) -> None:
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
        console.print(f"\n--details shows {listing(further)}", soft_wrap=True)


def _show_unknown(console: AnswerConsole, result: DiagnoseResult) -> None:
    """Draw the most probable law that no catalogue holds, where it is probable and has a curve."""
    law = next(iter(result.unknown or ()), None)
    if law is None or law.curve is None or not result.unexplained:
        return
    import numpy as np

    from stiffcal.cli.character_plot import plot_points

    unit = quantity_of(law.curve.value_unit).unit_for(law.curve.value)
    over = (JOINT_ANGLE if law.curve.unit == "rad" else quantity_of(law.curve.unit)).unit_for(law.curve.at)
    what, _, joint = law.curve.over.partition(":")
    labels = (f"{what} of joint {joint}", f"law of {law.of} that no catalogue holds")
    at, value = over.factor * np.array(law.curve.at), unit.factor * np.array(law.curve.value)
    console.print()
    for line in plot_points(at, value, labels, (over.name, unit.name), console.width):
        console.print(line, no_wrap=True, overflow="ignore", crop=False)


def _show_followed(console: AnswerConsole, followed: FollowedResidual) -> None:
    from stiffcal.cli.character_plot import plot_points

    labels, units = (followed.follows, followed.of), (followed.follows_unit, followed.unit)
    console.print()
    for line in plot_points(followed.x, followed.y, labels, units, console.width):
        console.print(line, no_wrap=True, overflow="ignore", crop=False)


def _show_with_all_missing(console: AnswerConsole, result: DiagnoseResult) -> None:
    """Print the error with several missing effects together: each row of the ranking adds only one."""
    if len(result.missing) < 2 or result.heldout_rms_with_missing is None:
        return
    names = listing(effect_words(effect) if dict(effect.where.items()) else effect.effect for effect in result.missing)
    noise = deviation(result.noise) if result.noise else "not known"
    left = f"{deviation(result.heldout_rms_with_missing)} in {held_out_by_diagnosis(result.heldout_rms_with_missing)}"
    validated = result.as_validated
    if validated is not None and validated.with_missing is not None:
        left += f", {deviation(validated.with_missing)} in {held_out(validated.scheme)}"
    console.print(f"with {names}: {left}, noise {noise}", soft_wrap=True)


def _show_missing(console: AnswerConsole, result: DiagnoseResult, effect: ProposedEffect, details: bool) -> None:
    console.print(f"\nmissing: {effect_words(effect)}{_sure_words(effect)}", soft_wrap=True)
    if effect.alternatives:
        names = ", ".join(look_alike_words(effect, alternative) for alternative in effect.alternatives)
        console.print(f"  cannot be distinguished from: {names}", soft_wrap=True)
    finding = result.finding_of(effect)
    if finding is None or finding.evidence is None:
        # found next to another effect: the ranking explains additions to the present model alone
        _show_refitted(console, result, effect)
        return
    explanation = finding.evidence
    for text in (explanation.seen, *[explanation.means] * details):
        console.print(f"  {text}", soft_wrap=True)
    _show_refitted(console, result, effect)
    if not details:
        return
    alike = "" if effect.alternatives else explanation.alike  # those are named above, each with how alike it is
    for text in (alike, explanation.check):
        if text:
            console.print(f"  {text}", soft_wrap=True)


def _sure_words(effect: ProposedEffect) -> str:
    """Return how sure the diagnosis is of an effect."""
    certain = "certain" if effect.firm else "not certain: improve adds it when asked, or with --likely"
    group, own = (probability_in_words(p or 0.0) for p in (effect.probability, effect.probability_of(effect)))
    if not effect.alternatives:
        return f": {group}, {certain}"
    return f": {group} that it or one of those below is, {own} that it is, {certain}"


def _show_in_model(console: AnswerConsole, result: DiagnoseResult) -> None:
    """Print how sure it is that the effects of the model are there, and what looks the same."""
    for effect in result.in_model or ():
        alike = ", ".join(look_alike_words(effect, other) for other in effect.alternatives)
        words = f"; cannot be distinguished from: {alike}" if alike else ""
        p = probability_in_words(effect.probability or 0.0)
        console.print(f"in the model: {effect_words(effect)}: {p}{words}", soft_wrap=True)


def _show_excluded(
    console: AnswerConsole, result: DiagnoseResult, folder: Path, store: str | None, details: bool
) -> None:
    """Print how large an effect at each place would have been found, where nothing is, and what load would decide."""
    if result.missing or result.unexplained or not result.excluded_sizes:
        return
    sizes = sorted(result.excluded_sizes, key=lambda one: (-(one.size_m or 0.0), -(one.size_Nm or 0.0)))
    hidden = [one.of for one in sizes if one.size_m is None and one.size_Nm is None]
    known = [one for one in sizes if one.of not in hidden]
    if known:
        measure = "torque, rms" if any(one.size_Nm for one in known) else "rms at the tool"
        shown = known if details else known[:MOST_PLACES]
        listed = ", ".join(f"{one.of} {_size_words(one.size_m, one.size_Nm)} ({one.effect})" for one in shown)
        listed += f"; less at {len(known) - len(shown)} further places (--details)" if len(shown) < len(known) else ""
        console.print(f"\nwould have been found in nine campaigns of ten, {measure}: {listed}", soft_wrap=True)
    if hidden:
        more = "; load along other axes, in other poses" if result.rms.torque is None else ""
        console.print(f"shows nowhere in this campaign: {', '.join(hidden)}{more}", soft_wrap=True)
    forces = sorted(((one.deciding_force_N, one.of) for one in sizes if one.deciding_force_N is not None), reverse=True)
    if forces:
        needed = ", ".join(f"{of} {significant(force)} N" for force, of in forces)
        line = command_line("plan", folder, "--force", f"{math.ceil(forces[0][0])}", store=store)
        console.print(
            f"to find there what is as large as the noise, load with up to: {needed}; to plan it: {line}",
            soft_wrap=True, markup=False, highlight=False,
        )  # fmt: skip


def _size_words(at_tool: float | None, torque: float | None) -> str:
    """Return the rms of an effect at the tool, m, or in a drive's torque, N·m, in words."""
    if torque:
        return f"{significant(torque)} N·m"
    return length(at_tool) if at_tool else NOT_KNOWN


def _show_refitted(console: AnswerConsole, result: DiagnoseResult, effect: ProposedEffect) -> None:
    """Print an effect's values with all that is missing in the model, which `improve` writes."""
    texts = []
    for value in result.before_after:
        if value.before is None and value.effect == effect.effect and value.where == effect.where:
            unit = value.quantity.unit_for([value.after.value if value.after else None])
            texts.append(f"{value.name.rpartition('.')[2]} {value_with_unit(value.after, unit)}")
    if texts:
        everything = "all that is missing" if len(result.missing) > 1 else "it"
        console.print(f"  Refitted with {everything}, ± 95 %: {', '.join(texts)}.", soft_wrap=True)


def _show_next_measurement(console: AnswerConsole, result: DiagnoseResult, folder: Path, store: str | None) -> None:
    measurement = result.next_measurement
    if measurement is not None:
        from stiffcal.stages.plans.plannable import plannable_words
        from stiffcal.stages.steps import RunContext

        pose = ", ".join(significant(value) for value in measurement.pose_deg)
        load = ", ".join(significant(value) for value in measurement.load[:3])
        between = " and ".join(effect_words(effect) for effect in measurement.separates)
        console.print(
            f"\nto distinguish {between}: pose ({pose})°, force ({load}) N in the axes in which forces are logged; "
            f"predicted difference {length(measurement.difference_m)}",
            soft_wrap=True,
        )
        largest = math.ceil(math.hypot(*measurement.load[:3]))
        words = plannable_words(folder, largest, RunContext(store=store))
        if words is not None:
            line = command_line("plan", folder, "--for", "look-alikes", *words, store=store)
            console.print(f"to plan runs that decide: {line}", soft_wrap=True, markup=False, highlight=False)
    elif len(result.missing) == 1 and result.missing[0].alternatives and result.rms.torque is None:
        console.print(
            "\nno load of this campaign's size, in any one pose, separates the two leading look-alikes by more than "
            "the noise",
            soft_wrap=True,
        )


def _show_pace(console: AnswerConsole, result: DiagnoseResult) -> None:
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
    console.print(
        f"\ncompared {pace.candidates} effects at their places{shapes} about "
        f"{pace.models} model{'s' * (pace.models != 1)} in {significant(pace.seconds)} s{left}",
        soft_wrap=True,
    )


def _show_ranking(console: AnswerConsole, result: DiagnoseResult, details: bool) -> None:
    """Show the ranking for the next single step, without details the first of what is not rejected alone."""
    probable = [finding for finding in result.findings if finding.verdict != "rejected"]
    shown = result.findings if details else probable[:MOST_ROWS]
    if not shown:
        return
    drawn, whole = console.width >= ROOMY, details or console.width >= ROOMY
    columns = ["effect", "place", "probability>", "held-out, rms>", "verdict"]
    table = plain_table(*columns, *["explains>", "size>"] * whole, *[""] * drawn)
    table.add_row("present model", "", "", deviation(result.rms))
    for finding in shown:
        explained = explained_in_words(result.explained_by(finding))
        table.add_row(
            finding.effect,
            short_places(finding.where),
            probability_in_words(finding.probability or 0.0),
            deviation(finding.heldout_rms_after),
            finding.verdict,
            *[explained, _size_words(finding.size_m, finding.size_Nm)] * whole,
            *([bar(BAR * (finding.probability or 0.0), None, BAR)] if drawn else []),
        )
    table.add_row("noise", "", "", deviation(result.noise) if result.noise else NOT_KNOWN)
    console.print()
    console.print(table)
    _show_found_later(console, result)
    if not details:
        return
    if any(finding.explains is not None for finding in result.findings):
        console.print(f"  {EXPLAINS}", soft_wrap=True)
    console.print(f"  {PROBABILITY}; {AT_TOOL}", soft_wrap=True)


def _show_found_later(console: AnswerConsole, result: DiagnoseResult) -> None:
    """Explain rows whose verdict is not the answer's: judged next to another effect, or significant and too small."""
    from stiffcal.diagnosis.answers.results import supported_but_not_named

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
        console.print(f"  {text}", soft_wrap=True)
    not_named = supported_but_not_named(result)
    if not_named is not None:
        text = f"{not_named.effect} ({places(not_named.where)}) lowers the error significantly and is not named: "
        text += "the rest has no explanation"
        console.print(f"  {text}", soft_wrap=True)

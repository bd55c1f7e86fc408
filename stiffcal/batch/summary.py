"""The summary of a batch for a CI system: JUnit XML for its test page, Markdown for the job's own page."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from pathlib import Path

from stiffcal.errors import InputError
from stiffcal.escapes import markdown, xml_text
from stiffcal.fault_codes import FaultCode
from stiffcal.files import check_stream, is_of_the_system
from stiffcal.measurements.rms import Rms
from stiffcal.quantity import LENGTH, MOMENT, Quantity
from stiffcal.results.batch_results import STEPS, BatchResult, CampaignOutcome
from stiffcal.results.batch_words import (
    choice_text,
    complaints_of,
    number_of_suspects,
    suspect_text,
    totals_of,
    verdict_of,
)
from stiffcal.trust.output_kinds import JUNIT, MARKDOWN, OutputKind
from stiffcal.trust.outputs import check_not_foreign, write_output
from stiffcal.wording import in_unit, share, significant


def prepare_files(markdown: Path | None, junit: Path | None, *, overwrite: bool = False) -> None:
    """Make the folders of files that are to be written after long work, and refuse now what cannot be one.

    Raises
    ------
    InputError : a file is a folder or a pipe, is named twice, holds something stiffcal did not write, or its folder
        cannot be made.
    """
    files = [(file, kind) for file, kind in ((markdown, MARKDOWN), (junit, JUNIT)) if file is not None]
    for place, (file, kind) in enumerate(files):
        try:
            file.parent.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            reason = f"its folder cannot be made ({error.strerror})"
            raise InputError.at(
                FaultCode.FILE_UNWRITABLE, str(file), "", reason, "choose a writable location"
            ) from None
        if file.is_dir():
            raise InputError.at(FaultCode.FILE_KIND, str(file), "", "this is a folder", "name a file in it")
        check_stream(file)
        check_not_foreign(file, kind, overwrite)
        if not is_of_the_system(file) and file.resolve() in [other.resolve() for other, _ in files[:place]]:
            reason = "two summaries cannot be in one file"
            raise InputError.at(FaultCode.OPTION_INVALID, str(file), "", reason, "name a file for each")


def write_summary(text: str, output: Path, kind: OutputKind, *, overwrite: bool = False) -> None:
    """Write a summary; a name of the running system (/dev/stdout) is written to as it is.

    Raises
    ------
    InputError : it cannot be written, or holds something stiffcal did not write.
    """
    if output.exists() and is_of_the_system(output):
        output.write_text(text, encoding="utf-8")
    else:
        write_output(output, text, kind, overwrite)


def junit_text(result: BatchResult) -> str:
    """Return JUnit XML: a suite per campaign; its cases are the steps and each threshold.

    A step that was wrong is an error, a threshold that does not hold a failure, what cannot be judged or was not
    reached is skipped.
    """
    root = ElementTree.Element("testsuites", name="stiffcal batch", time=f"{result.seconds:.3f}")
    for outcome in result.campaigns:
        cases = [*_steps(outcome), *_checks(outcome), *_choices(outcome), *_suspects(outcome)]
        suite = ElementTree.SubElement(
            root,
            "testsuite",
            name=xml_text.characters(outcome.campaign),
            time=f"{outcome.seconds:.3f}",
            tests=str(len(cases)),
            failures=str(sum(case.find("failure") is not None for case in cases)),
            errors=str(sum(case.find("error") is not None for case in cases)),
            skipped=str(sum(case.find("skipped") is not None for case in cases)),
        )
        if outcome.choices:
            properties = ElementTree.SubElement(suite, "properties")
            for choice in outcome.choices:
                value = xml_text.characters(choice_text(choice))
                ElementTree.SubElement(properties, "property", name=choice.kind, value=value)
        suite.extend(cases)
    for count in ("tests", "failures", "errors", "skipped"):
        root.set(count, str(sum(int(suite.get(count, "0")) for suite in root)))
    ElementTree.indent(root)
    return ElementTree.tostring(root, encoding="unicode", xml_declaration=True) + "\n"


def _case(outcome: CampaignOutcome, name: str, seconds: float = 0.0) -> ElementTree.Element:
    return ElementTree.Element(
        "testcase",
        classname=xml_text.characters(outcome.campaign),
        name=xml_text.characters(name),
        time=f"{seconds:.3f}",
    )


def _steps(outcome: CampaignOutcome) -> list[ElementTree.Element]:
    cases = []
    for step in STEPS:
        done = outcome.steps.get(step)
        if done is None and outcome.error is None:
            continue
        case = _case(outcome, step, done.seconds if done else 0.0)
        if done is None and step == outcome.failed_at:
            lines = complaints_of(outcome)
            _with(case, "error", lines[0], "\n".join(lines), outcome.state)
        elif done is None:
            _with(case, "skipped", f"not reached: {outcome.failed_at} failed")
        cases.append(case)
    return cases


def _checks(outcome: CampaignOutcome) -> list[ElementTree.Element]:
    cases = []
    for check in outcome.checks:
        case = _case(outcome, f"{check.threshold} {check.where}".strip())
        if check.held is False:
            _with(case, "failure", check.says, check.says, "threshold")
        elif check.held is None:
            _with(case, "skipped", check.says)
        cases.append(case)
    return cases


def _choices(outcome: CampaignOutcome) -> list[ElementTree.Element]:
    """Return one case that passes and carries what the author has chosen, in a place that CI systems show."""
    if not outcome.choices:
        return []
    case = _case(outcome, "set in campaign.toml")
    text = "\n".join(xml_text.characters(choice_text(choice)) for choice in outcome.choices)
    ElementTree.SubElement(case, "system-out").text = text
    return [case]


def _suspects(outcome: CampaignOutcome) -> list[ElementTree.Element]:
    """Return one case that passes and carries the runs that disagree with all the others."""
    if not outcome.suspects:
        return []
    case = _case(outcome, "suspect runs")
    text = "\n".join(xml_text.characters(suspect_text(suspect)) for suspect in outcome.suspects)
    ElementTree.SubElement(case, "system-out").text = text
    return [case]


def _with(case: ElementTree.Element, tag: str, message: str, text: str = "", kind: str = "") -> None:
    entry = ElementTree.SubElement(case, tag, message=xml_text.characters(message))
    if kind:
        entry.set("type", kind)
    if text:
        entry.text = "\n".join(map(xml_text.characters, text.split("\n")))


def markdown_text(result: BatchResult) -> str:
    """Return the summary as Markdown: the totals, what is wrong, a table of all campaigns."""
    title = "stiffcal: no campaign fails" if result.passed else "stiffcal: campaigns fail"
    lines = [f"## {title}", "", totals_of(result), ""]
    for outcome in result.campaigns:
        lines += [_item(outcome.campaign, line) for line in complaints_of(outcome)]
    lines += [f"- {markdown.escaped(warning)}" for warning in result.warnings]
    lines += [""] if lines[-1] else []
    headings = ["error in held-out data, mm rms", "of the deflection", "noise, mm", "states", "suspects", "s"]
    lines += [f"| campaign | verdict | {' | '.join(headings)} |", "|---|---|" + "---:|" * len(headings)]
    for outcome in result.campaigns:
        lines.append("| " + " | ".join(_row(outcome)) + " |")
    suspects = [(entry.campaign, suspect) for entry in result.campaigns for suspect in entry.suspects or ()]
    if suspects:
        lines += ["", "### Runs that disagree with all the others", ""]
        lines += [_item(name, suspect_text(suspect)) for name, suspect in suspects]
    chosen = [(entry.campaign, choice) for entry in result.campaigns for choice in entry.choices]
    if chosen:
        lines += ["", "### Chosen by the authors of the campaigns", ""]
        lines += [_item(name, choice_text(choice)) for name, choice in chosen]
    not_judged = [(entry.campaign, line) for entry in result.campaigns for line in entry.not_judged]
    if not_judged:
        lines += ["", "<details><summary>what could not be judged</summary>", ""]
        lines += [_item(name, line) for name, line in not_judged]
        lines += ["", "</details>"]
    return "\n".join(lines) + "\n"


def _item(campaign: str, line: str) -> str:
    return f"- **{markdown.escaped(campaign)}**: {markdown.escaped(line)}"


def _row(outcome: CampaignOutcome) -> list[str]:
    verdict = verdict_of(outcome)
    marked = verdict if verdict in ("held", "done") else f"**{verdict}**"
    torque = _part(outcome.rms, "torque")
    values = [
        _number(_part(outcome.rms, "translation"), LENGTH) if torque is None else in_unit(torque, MOMENT.usual),
        share(_part(outcome.relative, "translation")),
        _number(_part(outcome.noise, "translation"), LENGTH),
    ]
    states = "–" if outcome.n_states is None else str(outcome.n_states)
    took = "unchanged" if outcome.unchanged else f"{outcome.seconds:.1f}"
    return [markdown.escaped(outcome.campaign), marked, *values, states, number_of_suspects(outcome), took]


def _part(measures: Rms | None, name: str) -> float | None:
    return None if measures is None else dict(measures.items()).get(name)


def _number(value: float | None, quantity: Quantity) -> str:
    return significant(None if value is None else quantity.usual.factor * value)

"""`stiffcal effects`: the catalogue of physical effects."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from stiffcal.cli.answers import answering
from stiffcal.cli.endings import OK
from stiffcal.cli.options import HERE, AsJson, Output, Overwrite
from stiffcal.commands.next_step import following
from stiffcal.errors import InputError
from stiffcal.escapes.shell import command_line
from stiffcal.fault_codes import FaultCode
from stiffcal.presentation.values import NextStep

if TYPE_CHECKING:
    from stiffcal.cli.answers import Answer


def effects(
    name: Annotated[
        str | None, typer.Argument(metavar="NAME", help="One effect in full; or: new.", show_default=False)
    ] = None,
    new_name: Annotated[
        str | None, typer.Argument(metavar="NEW_NAME", help="After new: what to call it.", show_default=False)
    ] = None,
    source: Annotated[
        Path | None,
        typer.Option(
            "--from", metavar="DIR", help="The campaign whose own effects count too; after new: that needs it."
        ),
    ] = None,
    as_json: AsJson = False,
    output: Output = None,
    overwrite: Overwrite = False,
) -> int:
    """List the physical effects, or explain one.

    With a name: physics, law, places, parameters with units and typical sizes, required data, fingerprint, look-alikes,
    how to check it, and a sketch of its load-deformation curve; -o FILE draws the sketch as a picture.

    With --from DIR the effects of that campaign's plugins are listed too, once you trust them.

    `effects new NAME --from DIR` writes a plugin that tests the dependence that `diagnose` found and no effect
    of the catalogue explains, and adds it to campaign.toml; it runs once you trust it.

    Example: stiffcal effects backlash -o backlash.svg
    """
    with answering(as_json) as answer:
        if name == "new":
            _write_new(answer, new_name, source, output)
            return OK
        if new_name is not None:
            reason, mend = "goes with new only", "write: effects new NAME --from DIR"
            raise InputError.at(FaultCode.OPTION_CONFLICT, "command line", "NEW_NAME", reason, mend)
        from stiffcal.commands.effects import code_of_campaign, describe_effects

        if output is not None and name is None:
            raise InputError.at(
                FaultCode.OPTION_CONFLICT,
                "command line",
                "-o",
                "a picture is of one effect",
                "name it: effects NAME -o FILE",
            )
        plugins = None if source is None else code_of_campaign(source)
        result = describe_effects(name, plugins)
        if name is None:
            answer.show(result, NextStep("stiffcal effects joint-compliance"))
            return OK
        from stiffcal.report.effect_pictures.drawing import draw_effect, sketch_effect

        result = replace(result, sketch=sketch_effect(name, plugins))
        if output is not None:
            result = replace(result, picture=str(output), drawn=draw_effect(name, output, plugins, overwrite=overwrite))
        answer.show(result, _of_campaign(source or HERE))
    return OK


def _of_campaign(folder: Path) -> NextStep:
    """Return the step that a campaign calls for, where the folder holds one that can be read."""
    try:
        return following(folder, None)
    except InputError:
        return NextStep("stiffcal diagnose DIR", once="there is a campaign")


def _write_new(answer: Answer, name: str | None, source: Path | None, output: Path | None) -> None:
    """Write an effect that tests what a diagnosis found."""
    from stiffcal.commands.new_effect import write_new_effect
    from stiffcal.stages.steps import RunContext

    if name is None or source is None:
        place = "NAME" if name is None else "--from"
        mend = "write: effects new NAME --from DIR"
        raise InputError.at(FaultCode.OPTION_MISSING, "command line", place, "is missing", mend)
    if output is not None:
        reason = "no picture is drawn of a new effect"
        raise InputError.at(FaultCode.OPTION_CONFLICT, "command line", "-o", reason, "leave -o out")
    context = RunContext(progress=answer.progress, notify=answer.notify)
    result = write_new_effect(source, name, context)
    then = NextStep(command_line("trust", source), once=f"you have read {result.file}")
    answer.show(result, then)

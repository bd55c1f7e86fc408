"""Write an effect that tests what a diagnosis found where nothing in the catalogue accounts for the remainder."""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import NoReturn

from stiffcal.campaign.loading import load_campaign
from stiffcal.campaign.manifest.plugin_listing import list_plugin
from stiffcal.campaign.toml.naming import MANIFEST_FILE
from stiffcal.campaign.toml.reach import check_own
from stiffcal.commands.diagnose import diagnose_campaign
from stiffcal.diagnosis.answers.pattern_results import CompliancePattern
from stiffcal.diagnosis.answers.results import DiagnoseResult
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.files import write_whole
from stiffcal.model.catalogue.catalogue import built_in_effects
from stiffcal.model.catalogue.plugin_code import check_plugin_name, read_plugins
from stiffcal.results.command_results import NewEffectResult
from stiffcal.stages.steps import RunContext

# Lower case words with hyphens, as the catalogue's own; longer names do not fit into tables.
_NAME = re.compile(r"[a-z][a-z0-9]*(-[a-z0-9]+)*")
_LONGEST = 40


def write_new_effect(folder: Path, name: str, context: RunContext | None = None) -> NewEffectResult:
    """Write a plugin with an effect that tests the pattern which the diagnosis found, and list it in campaign.toml.

    Nothing of it runs before the user allows it with `stiffcal trust`.

    Parameters
    ----------
    folder : the campaign folder.
    name : of the effect: lower case words with hyphens.
    context : store, progress and so on.

    Raises
    ------
    InputError : the name is taken or cannot be one, the file exists, or the diagnosis found no pattern.
    """
    campaign = load_campaign(Path(folder), check_files=False)
    file = file_of_effect(name)
    _check_name(name, file, campaign.folder)
    diagnosis = diagnose_campaign(campaign.folder, context)
    pattern = diagnosis.pattern
    if pattern is None:
        _refuse_without_pattern(diagnosis)
    _check_finite(pattern)
    from stiffcal.diagnosis.remainder.pattern_plugin import plugin_text
    from stiffcal.diagnosis.words import pattern_in_words

    write_whole(campaign.folder / file, plugin_text(pattern, name))
    list_plugin(campaign.folder, file)
    plugins = read_plugins(campaign.folder, (*campaign.manifest.plugins, file))
    return NewEffectResult(warnings=[], effect=name, file=file, tests=pattern_in_words(pattern), sha256=plugins.digest)


def file_of_effect(name: str) -> str:
    """Return the file name of the plugin that defines a new effect."""
    return f"{name.replace('-', '_')}.py"


def _check_name(name: str, file: str, folder: Path) -> None:
    if not _NAME.fullmatch(name) or len(name) > _LONGEST:
        reason = f"{name} cannot be the name of an effect"
        mend = f"use lower case words of letters and digits with hyphens, at most {_LONGEST} characters"
        raise InputError.at(FaultCode.NAME_INVALID, "command line", "NAME", reason, mend)
    if name in built_in_effects():
        raise InputError.at(
            FaultCode.NAME_DUPLICATE, "command line", "NAME", f"{name} exists already", "choose another name"
        )
    check_plugin_name(file, folder)
    check_own(folder, file)
    if (folder / file).exists():
        raise InputError.at(FaultCode.FILE_EXISTS, file, "", "exists already", "choose another name, or remove it")


def _refuse_without_pattern(diagnosis: DiagnoseResult) -> NoReturn:
    if diagnosis.missing and not diagnosis.unexplained:
        names = ", ".join(effect.effect for effect in diagnosis.missing)
        reason = f"{names} of the catalogue explains the error of the model"
        mend = (
            "add it (stiffcal improve), or, where you know another cause, write the effect by hand and compare the "
            "errors of both (docs/how-to/own-effect.md)"
        )
    elif diagnosis.unexplained:
        reason = "in the unexplained error no joint's compliance depends on an angle, a torque, the load or the time"
        mend = "inspect the residuals (stiffcal plot), and write the effect by hand (docs/how-to/own-effect.md)"
    else:
        reason = "the catalogue explains the whole error"
        mend = "no new effect is needed"
    raise InputError.at(FaultCode.DATA_MISSING, MANIFEST_FILE, "runs", reason, mend)


def _check_finite(pattern: CompliancePattern) -> None:
    """Refuse numbers that are none: they become Python code."""
    numbers = [pattern.scale, *(parameter.value for parameter in pattern.parameters)]
    if not all(number is not None and math.isfinite(number) for number in numbers):
        raise InputError.at(
            FaultCode.DATA_MISSING, MANIFEST_FILE, "runs", "the values of the pattern are not numbers", "diagnose again"
        )

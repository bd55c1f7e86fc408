"""What is ticked on the page: a model that differs from model.toml by effects, and rows that are left out."""

from __future__ import annotations

import json
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

from stiffcal.campaign.manifest.manifest import Exclusion
from stiffcal.campaign.model.model_file import model_of_text
from stiffcal.errors import InputError
from stiffcal.escapes.toml_text import escaped
from stiffcal.fault_codes import FaultCode
from stiffcal.model.catalogue.campaign_effects import effects_with
from stiffcal.model.editing import model_with, model_without, places_at
from stiffcal.model.summary import Where

if TYPE_CHECKING:
    from stiffcal.campaign.loading import Campaign

PAGE = "the page"


@dataclass(frozen=True, kw_only=True)
class RowsLeftOut:
    """Rows of a source that are left out, as ``[[exclude]]`` names them."""

    source: str
    """The source."""
    rows: list[int | str]
    """Numbers, and ranges of them: 3, "7-9"."""
    run: str = ""
    """The run, where each has its own file; "" else."""

    def as_toml(self) -> str:
        """Return the lines for campaign.toml."""
        run = [f"run = {escaped(self.run)}"] if self.run else []
        rows = ", ".join(escaped(row) if isinstance(row, str) else str(row) for row in self.rows)
        return "\n".join(["[[exclude]]", f"source = {escaped(self.source)}", *run, f"rows = [{rows}]", 'why = "…"'])


@dataclass(frozen=True, kw_only=True)
class ModelChoice:
    """A model that is tried."""

    added: list[str] = field(default_factory=list)
    """Effects, ``effect place``, in the order in which they were ticked."""
    removed: list[str] = field(default_factory=list)
    """Effects of model.toml, ``effect place``, that were unticked."""
    excluded: list[RowsLeftOut] = field(default_factory=list)
    """Rows that are left out besides those of campaign.toml."""

    @property
    def key(self) -> str:
        """The same for the same model and rows, in whatever order they were ticked."""
        return json.dumps([sorted(self.added), sorted(self.removed), self.rows_key])

    @property
    def rows_key(self) -> str:
        """The same where the same rows are left out."""
        return json.dumps(sorted(json.dumps([one.source, one.run, one.rows]) for one in self.excluded))

    @property
    def label(self) -> str:
        """What differs from model.toml, in words."""
        words = [*(f"+ {name}" for name in self.added), *(f"− {name}" for name in self.removed)]
        left_out = sum(len(one.rows) for one in self.exclusions)
        rows = [f"without {left_out} {'row' if left_out == 1 else 'rows'}"] if left_out else []
        return " ".join([*words, *rows])

    @property
    def exclusions(self) -> tuple[Exclusion, ...]:
        """The rows that are left out, as the manifest has them.

        Raises
        ------
        pydantic.ValidationError : rows are no numbers or ranges of them.
        """
        return tuple(
            Exclusion.model_validate(
                {
                    "source": one.source,
                    "rows": one.rows,
                    "why": "left out on the page",
                    **({"run": one.run} if one.run else {}),
                }
            )
            for one in self.excluded
        )


def model_of_choice(campaign: Campaign, text: str, choice: ModelChoice) -> str:
    """Return model.toml with what is ticked, as `stiffcal remove` and then `stiffcal add` would write it.

    Parameters
    ----------
    campaign : as it was loaded. text : model.toml; "": the default model holds.

    Raises
    ------
    InputError : there is no such effect or place, or one is included in another.
    """
    n_joints = campaign.chain.n_joints
    for name in choice.removed:
        effect, where = placed_name(campaign, name)
        text = model_without(campaign, text, effect, where=where)
        campaign = replace(campaign, model=model_of_text(text, n_joints))
    for name in choice.added:
        effect, where = placed_name(campaign, name)
        text = model_with(campaign, text, effect, where=where, curved=False)
        campaign = replace(campaign, model=model_of_text(text, n_joints))
    return text


def placed_name(campaign: Campaign, name: str) -> tuple[str, Where]:
    """Return the effect and its place of ``effect place``.

    Raises
    ------
    InputError : there is no such effect.
    """
    effect, _, place = name.partition(" ")
    catalogue = effects_with(campaign, effect)
    if effect not in catalogue:
        reason, mend = f"unknown effect {effect}", "reload the page"
        raise InputError.at(FaultCode.EFFECT_UNKNOWN, PAGE, "effect", reason, mend)
    kind = catalogue[effect].place_kind
    if not place or kind == "setup":
        return effect, Where()
    if kind == "joints":
        return effect, places_at(campaign, joints=[place.removeprefix("j")])
    if kind == "pairs":
        return effect, places_at(campaign, pairs=[place.replace("j", "").split("-")])
    return effect, Where(links=[place])

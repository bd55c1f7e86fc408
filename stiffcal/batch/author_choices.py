"""What the author of a campaign has chosen that moves its verdict: rows and runs left out, thresholds of its own.

In a pull request the author of the data writes these too, so a summary for those who judge it names every one.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from stiffcal.campaign.loading import Campaign
from stiffcal.campaign.manifest.manifest import Manifest
from stiffcal.campaign.manifest.thresholds import Thresholds, ThresholdsFile, tighter
from stiffcal.escapes import toml_text
from stiffcal.results.batch_results import AuthorChoice


def author_choices(
    campaign: Campaign, file: ThresholdsFile | None, earlier: dict[str, object] | None
) -> list[AuthorChoice]:
    """Return every choice of a campaign's author, in the order of campaign.toml.

    Parameters
    ----------
    campaign : as loaded.
    file : the thresholds that the user gave, None where there are none.
    earlier : the thresholds of campaign.toml when its last validation was stored, None where nothing is known.
    """
    manifest = campaign.manifest
    return [*_row_filters(manifest), *_holdouts(manifest), *_excludes(manifest), *_thresholds(campaign, file, earlier)]


def _row_filters(manifest: Manifest) -> Iterator[AuthorChoice]:
    for source, settings in manifest.sources.items():
        if settings.rows:
            place = f"sources.{source}.rows"
            yield AuthorChoice(kind="row filter", place=place, text=f"only rows with {settings.rows}")
    for source, name, signal in manifest.signals():
        rows = getattr(signal, "rows", None)
        if rows:
            yield AuthorChoice(kind="row filter", place=f"sources.{source}.{name}.rows", text=f"only rows with {rows}")


def _holdouts(manifest: Manifest) -> Iterator[AuthorChoice]:
    runs = [run.id for run in manifest.runs if run.holdout]
    if runs:
        text = f"the held-out poses are those of {len(runs)} of {len(manifest.runs)} runs: {', '.join(runs)}"
        yield AuthorChoice(kind="holdout", place="runs", text=text)


def _excludes(manifest: Manifest) -> Iterator[AuthorChoice]:
    for number, entry in enumerate(manifest.exclude, 1):
        run = f" of run {entry.run}" if entry.run is not None else ""
        noun = "row" if len(entry.rows) == 1 else "rows"
        text = f"{entry.source}{run}: {noun} {_ranges(entry.rows)} ({len(entry.rows)}) left out: {entry.why}"
        yield AuthorChoice(kind="exclude", place=f"exclude[{number}]", text=text)


def _ranges(rows: Iterable[int]) -> str:
    """Return row numbers as ranges.

    Examples
    --------
    >>> _ranges((3, 7, 8, 9))
    '3, 7-9'
    """
    ranges: list[list[int]] = []
    for row in sorted(set(rows)):
        if ranges and row == ranges[-1][1] + 1:
            ranges[-1][1] = row
        else:
            ranges.append([row, row])
    return ", ".join(str(first) if first == last else f"{first}-{last}" for first, last in ranges)


def _thresholds(
    campaign: Campaign, file: ThresholdsFile | None, earlier: dict[str, object] | None
) -> Iterator[AuthorChoice]:
    of_campaign = campaign.manifest.thresholds.written()
    for key in sorted({*of_campaign, *(earlier or {})}):
        notes = []
        if earlier is not None and of_campaign.get(key) != earlier.get(key):
            notes.append(f"was {_shown(earlier.get(key))} at the last validation")
        if file is not None and key in of_campaign:
            notes.append(_against_file(key, campaign, file))
        if notes:
            text = f"{key} = {_shown(of_campaign.get(key))}: {'; '.join(notes)}"
            yield AuthorChoice(kind="threshold", place=f"thresholds.{key}", text=text)
    if file is not None:
        yield from _by_name_alone(campaign, file)


def _against_file(key: str, campaign: Campaign, file: ThresholdsFile) -> str:
    limits = file.own_limits(campaign.name, _folder(campaign))
    allowed = limits.written().get(key)
    if key == "baseline":
        return "the file states none" if allowed is None else "not used: the file states its own"
    if allowed is None and not (key == "max_drift" and limits.baseline is not None):
        return "only in campaign.toml"
    holds = tighter(limits, Thresholds.model_validate({key: campaign.manifest.thresholds.written()[key]}))
    if holds.written().get(key) == allowed:
        return f"not used: the file's {_shown(allowed)} is tighter"
    return f"tighter than the file's {_shown(allowed)}: {_shown(holds.written().get(key))} holds"


def _by_name_alone(campaign: Campaign, file: ThresholdsFile) -> Iterator[AuthorChoice]:
    name = campaign.name
    if name == _folder(campaign) or name not in file.campaigns:
        return
    before = file.campaigns[name].limits
    if file.own_limits(name, _folder(campaign)).written() != (file.limits.written() | before.written()):
        text = (
            f"{toml_text.pair('name', name)}: the thresholds of that name apply only where they are tighter, because "
            "the folder has another name"
        )
        yield AuthorChoice(kind="threshold", place="name", text=text)


def _folder(campaign: Campaign) -> str:
    return campaign.folder.resolve().name


def _shown(value: object) -> str:
    if value is None:
        return "none"
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{name} = {limit:g}" for name, limit in value.items()) + " }"
    return f"{value:g}" if isinstance(value, float | int) else f'"{value}"'

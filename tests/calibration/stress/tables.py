"""What a judge does with the stress classes, one line a class."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from statistics import median

from tests.calibration.judging import JudgedCampaign
from tests.rates.intervals import highest


def stress_table(classes: Mapping[str, Sequence[JudgedCampaign]]) -> str:
    """Return how many answers are good by class, how many firm and wrong with the 95 % limit, and seconds."""
    lines = [f"{'class':<28}{'good':>5}{'of':>5}  firm wrong   limit  median s"]
    lines += [_line(name, records) for name, records in classes.items() if records]
    pooled = [record for records in classes.values() for record in records]
    if len(classes) > 1 and pooled:
        lines.append(_line("all", pooled))
    for name, records in classes.items():
        lines += [f"firm wrong: {name} {record.number}: {_firm(record)}" for record in records if record.firm_wrong]
    return "\n".join(lines)


def _line(name: str, records: Sequence[JudgedCampaign]) -> str:
    wrong = sum(bool(record.firm_wrong) for record in records)
    return (
        f"{name:<28}{sum(record.good for record in records):>5}{len(records):>5}  {wrong:>10}"
        f"  {100.0 * highest(wrong, len(records)):5.1f} %"
        f"  {median(record.answer.seconds for record in records):8.1f}"
    )


def _firm(record: JudgedCampaign) -> str:
    """Return what is firm and wrong, and what is hidden, in words."""
    named = [one.names[0] for one in record.answer.named if one.firm and not set(one.names) & set(record.truth)]
    sizes = ", ".join(f"{size:.2f}" for size in record.sizes)
    return f"{', '.join(named)}; hidden: {', '.join(record.hidden) or record.category} at {sizes or 'no'} noises"

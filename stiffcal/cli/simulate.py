"""`stiffcal simulate`: raw logs of a known robot."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from stiffcal.cli.answers import answering
from stiffcal.cli.endings import OK
from stiffcal.cli.options import AsJson, Overwrite
from stiffcal.commands.next_step import to_begin


def simulate(
    out: Annotated[Path, typer.Argument(metavar="OUT", help="The campaign folder to create.")],
    source: Annotated[
        Path,
        typer.Option(
            "--from", metavar="DIR", help="Campaign with robot, model (every parameter with a value), simulate.toml."
        ),
    ],
    seed: Annotated[
        int | None,
        typer.Option(
            metavar="N",
            help="Random seed (default: that of simulate.toml); the same seed gives the same bytes.",
            show_default=False,
        ),
    ] = None,
    as_json: AsJson = False,
    overwrite: Overwrite = False,
) -> int:
    """Simulate a campaign: raw logs of a known robot.

    Robot and model of --from, with the sensors and their faults of simulate.toml.

    Example: stiffcal simulate twin --from campaigns/irb4400 --seed 1
    """
    with answering(as_json) as answer:
        from stiffcal.commands.simulate import simulate_campaign

        result = simulate_campaign(source, out, seed=seed, progress=answer.progress, overwrite=overwrite)
        answer.show(result, to_begin(out))
    return OK

"""The options that several commands share."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, TypeAlias

import typer

Folder: TypeAlias = Annotated[Path, typer.Argument(metavar="DIR", help="The campaign folder.", show_default=False)]
AsJson: TypeAlias = Annotated[bool, typer.Option("--json", help="Print one JSON document (SI units) and nothing else.")]
StoreAt: TypeAlias = Annotated[
    str | None,
    typer.Option("--store", metavar="URI", help="Location of the store (default: DIR/store).", show_default=False),
]
NoUpdate: TypeAlias = Annotated[
    bool, typer.Option("--no-update", help="Stop if an earlier step is missing or stale, instead of running it.")
]
Details: TypeAlias = Annotated[bool, typer.Option("--details", help="Show all of the answer, not only what decides.")]
Output: TypeAlias = Annotated[
    Path | None,
    typer.Option(
        "-o",
        "--output",
        metavar="FILE",
        help="Output file; a relative name is one of the current folder.",
        show_default=False,
    ),
]
Joints: TypeAlias = Annotated[
    str | None, typer.Option("--joints", metavar="2,3", help="Joints by number or name.", show_default=False)
]
Links: TypeAlias = Annotated[
    str | None, typer.Option("--links", metavar="swing,arm", help="Links by name.", show_default=False)
]
Pairs: TypeAlias = Annotated[
    str | None, typer.Option("--pairs", metavar="5-6", help="Pairs of joints by number.", show_default=False)
]
Thresholds: TypeAlias = Annotated[
    Path | None,
    typer.Option(
        "--thresholds", metavar="FILE", help="File of thresholds; a campaign can only tighten them.", show_default=False
    ),
]
Overwrite: TypeAlias = Annotated[
    bool,
    typer.Option("--overwrite", "--force", help="Also replace a file that holds something stiffcal did not write."),
]
OverwriteAlone: TypeAlias = Annotated[
    bool, typer.Option("--overwrite", help="Also replace a file that holds something stiffcal did not write.")
]
"""For commands whose `--force` is a load."""
HERE = Path()

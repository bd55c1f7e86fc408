"""What files of commands are. A file of one kind is never replaced by one of another, whoever has written it."""

from __future__ import annotations

from dataclasses import dataclass

PICTURES, TABLES = (".svg", ".png", ".pdf"), (".csv", ".xlsx", ".parquet")


@dataclass(frozen=True)
class OutputKind:
    """A kind of file that commands write.

    Attributes
    ----------
    name : under which the contents of such files are noted; no two kinds have one name.
    endings : of names that fit, lower case with their point; empty: any.
    """

    name: str
    endings: tuple[str, ...] = ()


REPORT = OutputKind("report", (".pdf",))
PAGE = OutputKind("page", (".html", ".htm"))
PLOT = OutputKind("plot of a run", PICTURES)
TREND_PICTURE = OutputKind("picture of a trend", PICTURES)
EFFECT_PICTURE = OutputKind("picture of an effect", PICTURES)
EXPORT = OutputKind("export", (*TABLES, ".json", ".toml", ".urdf", ".xml", ".c", ".st"))
PREDICTION = OutputKind("table of predictions", TABLES)
CORRECTION = OutputKind("table of corrected targets", TABLES)
PATH_PICTURE = OutputKind("picture of a path", PICTURES)
MAP_TABLE = OutputKind("table of a workspace", TABLES)
MAP_PICTURE = OutputKind("picture of a workspace", PICTURES)
RUN_SHEET = OutputKind("run sheet", (".csv", ".xlsx", ".pdf"))
PROGRAM = OutputKind("program of a robot")
MARKDOWN = OutputKind("summary in Markdown")
JUNIT = OutputKind("summary for JUnit")
MODEL = OutputKind("model")
LOG = OutputKind("simulated log")
TRUTH = OutputKind("truth of a simulation")
CAMPAIGN_FILE = OutputKind("file of a campaign")
README = OutputKind("explanation of the example")

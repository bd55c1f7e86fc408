"""Signals that no log holds, though load states need them: the lines of the log that is to be added."""

from __future__ import annotations

from dataclasses import dataclass

from stiffcal.campaign.manifest.file_patterns import RUN
from stiffcal.escapes import toml_text
from stiffcal.propose.column_roles import Roles
from stiffcal.propose.lines import FORCE_SENSOR, LOAD_POINT, TARGET, TRACKER


@dataclass(frozen=True)
class FurtherLog:
    """A signal that the log of a further instrument has to hold."""

    name: str
    """Of the role that its columns have."""
    what: str
    """In words."""
    frames: tuple[str, ...]
    """The frames that its line names."""
    source: str
    """The name of the source that is proposed."""
    signal: str
    """Its line."""

    @property
    def lines(self) -> tuple[str, ...]:
        """The lines of its source, as comments."""
        return (
            "",
            f"# {self.what}: no log here holds them. Add the logs and begin again with --overwrite, or fill in:",
            f"# [sources.{self.source}]",
            f"# {toml_text.pair('file', f'raw/{RUN}_{self.source}.csv')}",
            '# time = { column = "t", unit = "s" }',
            f"# {self.signal}",
        )


FURTHER = (
    FurtherLog(
        "joints", "joint angles", (), "controller",
        'joints = { position = ["A1", "A2", "A3", "A4", "A5", "A6"], units = { position = "deg" } }',
    ),
    FurtherLog(
        "load", "forces", (LOAD_POINT, FORCE_SENSOR), "ft",
        'wrench = { columns = ["Fx", "Fy", "Fz"], units = { force = "N" }, axes = "ft_sensor", point = "load_point" }',
    ),
    FurtherLog(
        "moved", "positions of the target", (TARGET, TRACKER), "tracker",
        'pose = { frame = "tracker", body = "target", position = ["X", "Y", "Z"], units = { position = "mm" } }',
    ),
)  # fmt: skip


def lacking_signals(roles: Roles) -> list[str]:
    """Return which of joint angles, load and displacement are not logged, as `FURTHER` names them."""
    given = {
        "joints": roles.joints is not None,
        "load": roles.force is not None or roles.mass is not None,
        "moved": roles.deflection is not None or roles.position is not None,
    }
    return [name for name, there in given.items() if not there]

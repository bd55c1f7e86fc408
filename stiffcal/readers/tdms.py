"""TDMS logs, as National Instruments' LabVIEW, DIAdem and FlexLogger write them. Needs the extra ``tdms`` (npTDMS).

Options of the manifest (``tdms = {…}``):

group : the group that holds the channels; may be left out where one group alone has any.

Columns are the group's channels. Channels that were written as waveforms carry no times but a step: their times are to
be had as a column ``time`` (s from the waveform's start), unless a channel has that name. Units come from the property
``unit_string`` (or ``NI_UnitDescription``). Scalings that are stored with a channel are applied.

npTDMS reads a file whose writer died up to where it goes: such a file is refused, as are channels of unequal length.
"""

from __future__ import annotations

from pathlib import Path

from stiffcal.campaign.toml.typed import Name, TomlTable
from stiffcal.readers import FuzzInput, ParsedReader


class TdmsOptions(TomlTable):
    """Where in a TDMS file the channels lie: the group; may be left out where only one group has any."""

    group: Name | None = None


def _write_fuzz_input(path: Path) -> None:
    import numpy as np
    from nptdms import ChannelObject, TdmsWriter

    columns = {"t": np.linspace(0.0, 0.6, 60), "Fx": np.arange(-30.5, 29.0)}
    with TdmsWriter(path) as writer:
        writer.write_segment([ChannelObject("ft", name, values) for name, values in columns.items()])


class TdmsReader(ParsedReader):
    """Reads TDMS files in batches of rows."""

    name = "tdms"
    endings = (".tdms",)
    first_bytes = b"TDSm"
    options = TdmsOptions
    holds_tables = True
    fuzz_inputs = (FuzzInput(".tdms", _write_fuzz_input, ("t", "Fx")),)


READER = TdmsReader()

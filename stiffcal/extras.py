"""The libraries of optional parts, and the line that installs each: it works wherever stiffcal itself was got from."""

from __future__ import annotations

EXTRAS = {
    "dask": "distributed>=2024.8",
    "section": "scikit-fem>=10",
    "tdms": "npTDMS>=1.9",
    "ros": "rosbags>=0.11.9",
    "c3d": "ezc3d>=1.6",
    "postgres": "adbc-driver-postgresql>=1.3",
}
"""By the extra's name in `pyproject.toml`, which states the same."""


def install_command(extra: str) -> str:
    """Return the line that installs the library of an extra.

    Examples
    --------
    >>> install_command("tdms")
    'python -m pip install "npTDMS>=1.9"'
    """
    return f'python -m pip install "{EXTRAS[extra]}"'

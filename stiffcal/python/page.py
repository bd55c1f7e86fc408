"""The page for a browser, in Python: a notebook shows it inside itself."""

from __future__ import annotations

import html
from pathlib import Path

from stiffcal.trust.output_kinds import PAGE
from stiffcal.trust.outputs import check_output, write_output

SANDBOX = "allow-scripts allow-downloads"
"""What the page may do inside a notebook: run its own scripts and hand out files; nothing of the notebook's."""


class CampaignPage:
    """The page of a campaign; the last line of a cell shows it.

    Parameters
    ----------
    html : the whole file.
    height : px, in a notebook.
    """

    def __init__(self, html: str, height: int) -> None:
        self.html = html
        self.height = height

    def save(self, file: str | Path, *, overwrite: bool = False) -> None:
        """Write it as a file that a browser opens.

        Parameters
        ----------
        file : ``*.html``.
        overwrite : also a file that holds something stiffcal did not write.

        Raises
        ------
        InputError : the name does not end in .html, or the file cannot be written or holds something else.
        """
        check_output(Path(file), PAGE, overwrite)
        write_output(Path(file), self.html, PAGE, overwrite)

    def _repr_html_(self) -> str:
        return (
            f'<iframe title="stiffcal view" sandbox="{SANDBOX}" srcdoc="{html.escape(self.html, quote=True)}" '
            f'style="width: 100%; height: {int(self.height)}px; border: 0"></iframe>'
        )

    def __repr__(self) -> str:
        return f"<page of a campaign, {len(self.html) // 1000} kB: a notebook shows it, save() writes it>"

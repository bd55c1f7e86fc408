"""Pictures on axes of one's own."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

import numpy as np

from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.python.frames import column_values
from stiffcal.python.notebook import svg_of

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

LENGTHS, ANGLES = ("dx", "dy", "dz"), ("rx", "ry", "rz")


class WithResiduals(Protocol):
    """A campaign, as far as its pictures need it."""

    def drawn(self, run: str | None, against: str | None, of: str | None) -> tuple[Figure, str]:
        """Return the picture that ``stiffcal plot`` draws, and what is in it."""

    def residuals(self, heldout: bool = True) -> pd.DataFrame:
        """Return the residual of every reading with what it may follow."""


class CampaignPicture:
    """A picture of a campaign, which a notebook shows.

    Parameters
    ----------
    figure : of matplotlib. title : what is in it.
    """

    def __init__(self, figure: Figure, title: str) -> None:
        self.figure = figure
        self.title = title

    def _repr_html_(self) -> str:
        return svg_of(self.figure)

    def __repr__(self) -> str:
        return f"<picture: {self.title}>"


class CampaignPlots:
    """Pictures of a campaign.

    Parameters
    ----------
    session : the campaign.
    """

    def __init__(self, session: WithResiduals) -> None:
        self._session = session

    def load_deformation(self, run: str | None = None) -> CampaignPicture:
        """Draw load against deformation, or what the kind of experiment draws of its runs.

        Parameters
        ----------
        run : only this run.

        Raises
        ------
        InputError : there is no such run, or nothing to draw.
        """
        return CampaignPicture(*self._session.drawn(run, None, None))

    def against(self, quantity: str, run: str | None = None) -> CampaignPicture:
        """Draw the residual in held-out poses against what it may follow.

        Parameters
        ----------
        quantity : as ``stiffcal plot --against`` takes it: ``torque:4``, ``angle:2``, ``force:x``, ``load``, …
        run : only this run.

        Raises
        ------
        InputError : there is no such run or quantity.
        """
        return CampaignPicture(*self._session.drawn(run, quantity, None))

    def of_fit(self, picture: str) -> CampaignPicture:
        """Draw a picture of the fit.

        Parameters
        ----------
        picture : ``normal`` (residuals against a normal law), ``influence`` (of each run on each value),
            ``correlation``, ``profile`` (of values near a bound or that bend a law), ``history``.

        Raises
        ------
        InputError : there is no such picture, or nothing to draw.
        """
        return CampaignPicture(*self._session.drawn(None, None, picture))

    def residual(
        self,
        against: str,
        *,
        component: str | None = None,
        color: str | None = None,
        heldout: bool = True,
        ax: Axes | None = None,
    ) -> Axes:
        """Draw the residual of the first target against a column of `CampaignSession.residuals`.

        Parameters
        ----------
        against : the column, with its unit or without: ``tau_4``, ``load_N``, ``A1_deg``.
        component : ``dx``, ``dy``, ``dz`` (base axes), ``rx``, ``ry``, ``rz``; None: the displacement that is largest,
            whatever the model.
        color : a column that colours the points.
        heldout : in poses that the fit has left out, or of the fit itself.
        ax : where to draw; None: on axes of its own.

        Returns
        -------
        Axes
            Those that were drawn on.

        Raises
        ------
        InputError : there is no such column or component.
        """
        from stiffcal.report.figures.residual_scatter import ScatterContent, draw_residual_scatter

        frame = self._session.residuals(heldout)
        components = {
            name: column
            for column in frame.columns
            for name in (*LENGTHS, *ANGLES)
            if column.endswith((f"_{name}_m_residual", f"_{name}_rad_residual"))
        }
        first = {name: next(column for column in frame.columns if _is_of(column, name)) for name in components}
        if component is None:
            # of what was measured: the same for every model of the campaign, so that their pictures compare
            measured = {name: first[name].removesuffix("residual") + "measured" for name in LENGTHS if name in first}
            sizes = {name: float(np.nanmean(frame[column] ** 2)) for name, column in measured.items()}
            component = max(sizes, key=lambda name: sizes[name]) if sizes else next(iter(first), "")
        if component not in first:
            reason, mend = f"unknown component {component or '(nothing)'}", f"choose {', '.join(first) or 'none'}"
            raise InputError.at(FaultCode.OPTION_INVALID, "plot.residual", "component", reason, mend)
        values, label = column_values(frame, against)
        shades, shade_label = (None, "") if color is None else column_values(frame, color)
        return draw_residual_scatter(
            ScatterContent(
                values=np.asarray(values, dtype=np.float64),
                label=label,
                residual=frame[first[component]].to_numpy(),
                component=component,
                rotation=component in ANGLES,
                shades=None if shades is None else np.asarray(shades, dtype=np.float64),
                shade_label=shade_label,
            ),
            ax,
        )


def _is_of(column: str, component: str) -> bool:
    return column.endswith((f"_{component}_m_residual", f"_{component}_rad_residual"))

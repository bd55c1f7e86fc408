"""What `diagnose` answers on one effect at all joints at once, where no effect at one joint can be named."""

from __future__ import annotations

from dataclasses import dataclass

from stiffcal.model.summary import EffectAt


@dataclass(frozen=True, slots=True, kw_only=True)
class ErrorLeftOut:
    """Mean distance between predicted and measured places in poses left out of the fit, m."""

    before: float
    """Of the present model."""
    after: float
    """With the effect at all of its joints."""
    standard_errors: float
    """The fall of the squared distances, in its standard errors over poses."""


@dataclass(frozen=True, slots=True, kw_only=True)
class EffectEverywhere(EffectAt):
    """An effect at all of its joints together: it lowers the error in poses left out, and names no cause."""

    n_parameters: int
    """Parameters that it adds to the model, at all joints."""
    heldout_random: ErrorLeftOut
    """A sixth of the poses at a time left out, drawn at random."""
    heldout_region: ErrorLeftOut
    """One of six regions of the joints' ranges at a time left out."""

"""What a manifest states of logged angles."""

from __future__ import annotations

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.campaign.loading import Campaign
from stiffcal.campaign.signals.signals import JointSignals


def stated_units(campaign: Campaign) -> Floats:
    """Return (L,) the units that the manifest states of the logged angles, rad; 1 of a prismatic joint's length."""
    count = campaign.chain.coupling.shape[1]
    signal = next((signal for _, _, signal in campaign.manifest.signals() if isinstance(signal, JointSignals)), None)
    units = () if signal is None else signal.position_units(count)
    if len(units) != count:
        return np.ones(count)
    return np.array([own.factor if own.quantity == "angle" else 1.0 for own in units])

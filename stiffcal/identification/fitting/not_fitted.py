"""Which faults mean that a model cannot be fitted to its data, and not that something else is wrong with the input."""

from __future__ import annotations

from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode

NOT_FITTED = frozenset({FaultCode.NO_BALANCE, FaultCode.NO_CONVERGENCE, FaultCode.MODEL_UNSUITABLE})


def is_not_fitted(error: InputError) -> bool:
    """Return whether a fit found no equilibrium, did not converge, or has columns that are no numbers.

    Examples
    --------
    >>> is_not_fitted(InputError.at(FaultCode.NO_CONVERGENCE, "model.toml", "effects", "no convergence", "fix one"))
    True
    >>> is_not_fitted(InputError.at(FaultCode.PLUGIN_FAILED, "mine.py", "line 3", "division by zero", "correct it"))
    False
    """
    return all(fault.code in NOT_FITTED for fault in error.faults)

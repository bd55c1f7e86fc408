"""Arrays in answers: nested lists of numbers in their documents.

In a module of its own, as it needs numpy: what only reads the store does without.
"""

from __future__ import annotations

from typing import Annotated, TypeAlias

import numpy as np
from numpy.typing import NDArray

from stiffcal.documents import ListsOf

Vector: TypeAlias = Annotated[NDArray[np.float64], ListsOf(1)]
Matrix: TypeAlias = Annotated[NDArray[np.float64], ListsOf(2)]
VectorWithGaps: TypeAlias = Annotated[NDArray[np.float64], ListsOf(1, gaps=True)]

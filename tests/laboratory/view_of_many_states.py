"""The page of a campaign with as many states as one likes, made from that of a small one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.view.content import ViewContent

RAW_COLUMNS = 19
"""Of a raw row: a clock, six angles, six components of the wrench, six of the pose."""


def with_many_states(content: ViewContent, drawn: int, n_states: int) -> ViewContent:
    """Return the page with its states repeated, scatter of the size of the noise on every array of numbers.

    Parameters
    ----------
    content : of a small campaign.
    drawn : how many states are drawn.
    n_states : how many the campaign is said to hold.
    """
    states, noise = content.states, content.noise
    assert states is not None
    assert noise is not None
    sigma = noise.translation
    assert sigma is not None
    n, generator = len(states.run), np.random.default_rng(11)
    pick = np.arange(drawn) % n
    copies = -(-drawn // n)

    def scattered(values: Floats | None) -> Floats | None:
        if values is None:
            return None
        many = values[pick]
        return np.asarray(many + sigma * generator.normal(size=many.shape))

    runs = [replace(run, name=f"{run.name}-{copy}") for copy in range(copies) for run in content.runs]
    measured, shape = scattered(states.measured), scattered(states.shape)
    assert measured is not None
    assert shape is not None
    return replace(
        content,
        n_states=n_states,
        runs=runs,
        states=replace(
            states,
            run=states.run[pick] + len(content.runs) * (np.arange(drawn) // n),
            row=np.arange(drawn),
            first_row=np.arange(drawn) + 1,
            last_row=np.arange(drawn) + 1,
            used=states.used[pick],
            why=[states.why[k] for k in pick],
            lines=[",".join(f"{cell:.9g}" for cell in row) for row in generator.normal(size=(drawn, RAW_COLUMNS))],
            line_number=np.arange(drawn) + 2,
            measured=measured,
            force=states.force[pick] + generator.normal(size=(drawn, 3)),
            shape=shape,
            target=states.target[pick],
        ),
        variables=[
            replace(v, values=v.values[pick] if v.levels else v.values[pick] * generator.uniform(0.99, 1.01, drawn))
            for v in content.variables
        ],
        models=[
            replace(m, residual_fit=scattered(m.residual_fit), residual_heldout=scattered(m.residual_heldout))
            for m in content.models
        ],
        effects=[replace(e, part=e.part[pick] * generator.uniform(0.99, 1.01, (drawn, 1))) for e in content.effects],
        readings={k: v[pick] * generator.uniform(0.99, 1.01, drawn) for k, v in content.readings.items()},
    )

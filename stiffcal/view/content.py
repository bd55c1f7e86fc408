"""What the page for a browser is made of: finished results of the other rooms, as plain arrays and words, SI units.

Fields are written to the page under their own names; the scripts read them by these names (`stiffcal/view/data.js`).
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal, TypeAlias

import numpy as np

from stiffcal.arrays import Booleans, Floats, Integers
from stiffcal.measurements.rms import Rms
from stiffcal.presentation.values import Page
from stiffcal.quantity import ANGLE, LENGTH, ShownUnit, Units, of_measure


@dataclass(frozen=True, kw_only=True)
class ViewRun:
    """A run of load states."""

    name: str
    """Its id."""
    chain: Floats
    """(K, 3) m, base axes: base origin, joint origins, flange (K = J + 2), at rest."""
    axes: Floats
    """(J, 3) unit vectors along the joints' axes, base axes, at rest."""
    across: Floats = field(default_factory=lambda: np.zeros((0, 3)))
    """(J, 3) unit vectors along the x axes of the joints' frames, base axes, at rest; empty where there are no
    `ViewBody`.
    """
    holdout: bool = False
    """True where no fit uses it."""
    files: list[str] = field(default_factory=list)
    """Its logs, relative to the campaign folder."""
    source: str = ""
    """The source that `ViewStates.first_row` counts in, for ``[[exclude]]``; "" where none is known."""
    is_sampled: bool = False
    """True where its states were found in logs sampled over time, False where they are rows of a table."""
    own_file: bool = False
    """True where that source has a file of its own for this run."""
    first_row: str = ""
    """Where data row 1 of that source stands in its file, in words; "" where that is not known."""
    columns: list[str] = field(default_factory=list)
    """The columns of that file; empty where it is no text."""


@dataclass(frozen=True, kw_only=True)
class ViewBody:
    """What the base or a joint's link looks like, in its own frame: of a joint z along its axis."""

    body: int
    """0 the base, k what joint k moves."""
    points: Floats
    """(V, 3) m."""
    triangles: Integers
    """(T, 3) indices of points."""


@dataclass(frozen=True, kw_only=True)
class ViewVariable:
    """Something that a residual can be drawn against."""

    name: str
    """For the URL: "torque2"."""
    label: str
    """As it is printed."""
    unit: str
    """As it is printed; "" where there is none."""
    values: Floats
    """(n,) in that unit; NaN where not known."""
    levels: list[str] = field(default_factory=list)
    """Texts of the values 0, 1, …; empty where values are numbers."""


@dataclass(frozen=True, kw_only=True)
class ViewValue:
    """A parameter of a model; of a compliance the stiffness."""

    name: str
    """``effect.place.symbol``."""
    unit: str
    """As it is printed; "" where there is none."""
    value: float | None
    """SI; None where it is not identified, or a stiffness without upper limit."""
    text: str
    """As it is printed, in that unit, with its 95 % interval."""
    is_identified: bool = True
    """Whether its value, or a limit of it, is known."""


@dataclass(frozen=True, kw_only=True)
class ViewShare:
    """How much of a residual a variable explains, over all states."""

    variable: str
    """Its name."""
    component: str
    """Which residual: "x", "y", "z", "rx", "ry", "rz"."""
    share: float
    """Of the squares about the mean, 0 to 1."""


@dataclass(frozen=True, kw_only=True)
class ViewModel:
    """A model that the panels can show: a fit of the history, or a refit that `diagnose` stored."""

    id: str
    """For the URL: "fit3", "all1", "with2", "without1"."""
    kind: Literal["fit", "with", "without", "all"]
    """A fit of the history; the present model with a candidate, without one of its effects, or with all that is
    missing.
    """
    label: str
    """As it is printed."""
    short: str
    """As the head of a column: "fit 1", "with backlash j4"."""
    present: bool = False
    """True for the fit of the present model."""
    fit_rms: Rms | None = None
    """Of the fit, all states, as in ``history``."""
    heldout_rms: Rms | None = None
    """In held-out poses, all states, as in ``history``."""
    values: list[ViewValue] = field(default_factory=list)
    """Parameters; empty where they are not known."""
    effect: str = ""
    """Of a refit: ``effect place``; of all that is missing their names."""
    residual_fit: Floats | None = None
    """(n, 3) or (n, 6) m and rad; None where the store does not hold it."""
    residual_heldout: Floats | None = None
    """Likewise, each pose by a fit without it."""
    shares: list[ViewShare] = field(default_factory=list)
    """What explains its residual, largest first."""
    remark: str = ""
    """What an effect that was added does not gain, or costs, in a sentence; "" where the error falls."""


@dataclass(frozen=True, kw_only=True)
class ViewForecast:
    """What one linear step is going to leave, before anything is fitted."""

    models: list[ViewModel | None]
    """One for each part of the page: the content, then its ``others``; None where the step changes nothing there."""


@dataclass(frozen=True, kw_only=True)
class ViewEffect:
    """An effect of the present model at a place."""

    name: str
    """``effect place``."""
    joint: int | None
    """Its joint, or the joint that moves its link, from 1; None for the set-up and couplings."""
    part_of: Literal["joint", "bearing", "link", "setup"]
    """What gives: a drive about its joint's axis, a joint's bearing, a link, or none of them."""
    removable: bool
    """True of effects of model.toml; False of frames, which the measurement brings with it."""
    share: float
    """Of the squares of the predicted deflection."""
    part: Floats
    """(n, 3) or (n, 6): prediction less that of the model without it, m and rad."""


CandidateStanding: TypeAlias = Literal["missing", "alike", "undecided", "possible", "rejected"]
"""What the diagnosis says of a candidate: missing, not to be distinguished from one that is, one of several between
which poses decide, possible, or rejected.
"""


@dataclass(frozen=True, kw_only=True)
class ViewCandidate:
    """An effect at a place that the model lacks, or may lack."""

    name: str
    """``effect place``."""
    standing: CandidateStanding
    """What the diagnosis says of it."""
    sure: str
    """How sure the diagnosis is of it, in words; "" where it does not say."""
    heldout_rms: Rms | None
    """In held-out data by a linear refit with it; None where none was made."""
    why: str
    """The verdict's reason, "" for none."""
    command: str
    """The line for a terminal that adds it."""


@dataclass(frozen=True, kw_only=True)
class ViewLive:
    """What the page shows of models that are tried on a server."""

    added: list[str]
    """Effects, ``effect place``, that model.toml does not hold."""
    removed: list[str]
    """Effects that it holds and the shown model does not."""
    excluded: list[str]
    """Lines ``[[exclude]]`` for campaign.toml, one block each, without which the shown model was fitted."""
    forecasts: bool
    """Whether forecasts can be asked for: of a part of the readings, at least."""


@dataclass(frozen=True, kw_only=True)
class ViewEvidence:
    """An effect that is missing or was added last, with what it follows and the direction in which it acts."""

    name: str
    """``effect place``."""
    standing: Literal["missing", "added"]
    """Whether the present model lacks it, or holds it and the fit before did not."""
    variable: str
    """Name of the variable that it follows."""
    turns: bool
    """True where the direction is of rotations, False of translations."""
    along: Floats
    """(n, 3): its inner product with a residual is the residual along the effect; NaN where it cannot be read."""


@dataclass(frozen=True, kw_only=True)
class ViewChange:
    """What the present model holds and an earlier one did not: the page opens on it."""

    before: str
    """Id of the earlier model."""
    added: list[str]
    """Effects, ``effect place``."""
    variable: str
    """Name of the variable that the first of them follows; "" where nothing is known to follow any."""
    component: str
    """Which residual shows it: one of `ViewShare.component`, or "e1", "e2", … of the evidence; "" likewise."""


@dataclass(frozen=True, kw_only=True)
class ViewStates:
    """n load states, grouped by run, in the order in which they were reached."""

    index: Integers
    """(n,) numbers among all states or rows of the campaign, from 0, ascending."""
    run: Integers
    """(n,) index into the runs."""
    row: Integers
    """(n,) data row of the table, or number of the hold."""
    first_row: Integers
    """(n,) first data row of the run's source that it is of; 0 where not known."""
    last_row: Integers
    """(n,) the last one: between them are the rows that it was averaged over, of torque over motion the whole pass."""
    used: Booleans
    """(n,) False for states set aside and references."""
    why: list[str]
    """(n,) why a state is not used; "" where it is."""
    lines: list[str]
    """(n,) the raw row, or the middle one of several, as it stands in its file; "" where that is no text."""
    line_number: Integers
    """(n,) line of that row in the file, from 1; 0 where it is no text."""
    measured: Floats
    """(n, 3) or (n, 6) m and rad, base axes, since the run's reference."""
    force: Floats
    """(n, 3) N, base axes."""
    shape: Floats
    """(n, K, 3) m: how far the points of the chain move under the load, base axes."""
    target: Floats
    """(n, 3) m: the measured point at rest, base axes."""
    turns: Floats = field(default_factory=lambda: np.zeros((0, 0, 3)))
    """(n, J + 1, 3) rad: how far base and joints' frames turn under the load, base axes; empty where there are no
    `ViewBody`.
    """


@dataclass(frozen=True, kw_only=True)
class ViewContent:
    """All that the page shows."""

    campaign: str
    robot: str
    fit_id: str
    """Number of the present fit, "" where there is none."""
    verdict: str
    """The diagnosis in a sentence."""
    noise: Rms | None
    """In the measure of every rms; None where it cannot be judged."""
    zero: Rms | None
    """The error with no model at all, all states; None where it is not known."""
    suspected: list[int]
    """Joints from 1 where the diagnosis misses an effect."""
    suspected_links: list[int]
    """Links where it misses one, by the joint that moves them, from 1; 0 for the base."""
    suspects: list[str]
    """The missing effects with their places, "link-beam swing"."""
    n_states: int
    """All load states; more than are drawn where a sample is drawn."""
    joints: list[str]
    """Their names."""
    rotation: bool
    """True where rotations were measured."""
    one_direction: bool
    """True where each state was measured along one direction: components across it are zero and not measured."""
    measure: Literal["translation", "motor_angle", "length", "torque"]
    """What errors are compared in. Residuals of states are drawn of translations; of the moved motor's angle and of
    the torque they are (n, 3) rad or N·m with zeros in the second and third column.
    """
    direction: str
    """Name of the variable by which errors are cut next to the run."""
    runs: list[ViewRun]
    states: ViewStates | None
    """Those that are drawn; None where the campaign holds none."""
    variables: list[ViewVariable]
    models: list[ViewModel]
    """Fits, oldest first, then refits."""
    effects: list[ViewEffect]
    evidence: list[ViewEvidence]
    """In the order of the diagnosis."""
    change: ViewChange | None
    """How the present model differs from the fit before it; None where it holds no more, or that cannot be drawn."""
    diagnosed: Rms | None
    """The error of the present fit as the diagnosis judges it, with which candidates compare; None without one."""
    held_out: str
    """What the fit has left out, in words: "held-out poses"."""
    readings: dict[str, Floats]
    """What the store holds of each drawn state, (n,) each, by column; empty with ``--no-raw``."""
    raw: bool
    """False with ``--no-raw``."""
    pages: list[Page]
    """What other kinds of experiment show."""
    refits_missing: str
    """Why candidates cannot be shown, "" where they can."""
    in_model: str = ""
    """How sure the diagnosis is that effects of the model are there, and what cannot be distinguished from them."""
    excluded_sizes: str = ""
    """Where the diagnosis finds nothing: how large an effect would have been found."""
    candidates: list[ViewCandidate] = field(default_factory=list)
    """What the diagnosis says could be added, the most likely first."""
    is_diagnosed: bool = False
    """Whether there is a diagnosis, of the present model or of another."""
    diagnosis_of: str = ""
    """Of which model the verdict and the candidates are, where it is not the present one; "" where it is."""
    live: ViewLive | None = None
    """What is tried on a server; None of a page by itself."""
    bodies: list[ViewBody] = field(default_factory=list)
    """Base to wrist, from the meshes of the URDF; what has none is drawn as a round body."""
    meshes_fault: str = ""
    """Why there are none, though the campaign folder holds meshes; "" otherwise."""
    fitted_rows: Integers | None = None
    """Of each row of the fit's table the drawn one, −1 where it is not drawn; None where states are drawn."""
    others: list[ViewContent] = field(default_factory=list)
    """Readings of another kind in the same campaign, which have a page of panels of their own: torques of moving joints
    next to load states; their ``pages`` are empty.
    """

    @property
    def units(self) -> dict[str, ShownUnit]:
        """Units of what the scripts write: of all lengths, all angles, and what errors are compared in."""
        units = Units.of_errors([self.zero, self.noise])
        return {"length": units.of(LENGTH), "angle": units.of(ANGLE), "main": units.of(of_measure(self.measure))}

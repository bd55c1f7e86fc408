"""All numbers of the judgement: what is assumed before any reading, where an answer begins, how far sets are sought.

They stand here and nowhere else (a test), and depend on no reading and on no number of readings. Those of which nothing
else is said are published in docs/explanation/judging.md or derived next to them. "Ours" are the others, with the
largest change of a probability in six practice campaigns when they are doubled and halved (`python -m tests.calibration
numbers --practice`).
"""

from __future__ import annotations

import numpy as np

# What is assumed: how many effects are missing, how large they are.

SPRING = 0.5
"""Probability that a joint gives, or has friction, where the model lacks its spring, or its friction: ours, even odds
(0, 0: all have one).
"""
EXPECTED_EFFECTS = 0.8
"""Effects beyond the present model that are expected in all."""
UNLISTED = 0.25
"""Share of each place that belongs to laws that nobody has written down."""
SIZE_FACTOR = 5.0
"""A parameter lies within this factor of the catalogue's typical size in two cases of three."""
_SPREAD = np.linspace(-3.6, 3.6, 21)
SIZES = np.exp(np.log(SIZE_FACTOR) * _SPREAD)
"""Grid of a listed effect's common size over the typical one, as far as one of three thousand lies …"""
SIZE_WEIGHTS = np.exp(-0.5 * _SPREAD**2)
"""… and its weights (log-normal), not normalised."""
ALONE = 0.5
"""Probability that one of an effect's parameters stands alone: a bearing that gives along one axis."""
UNLISTED_SIZES = np.geomspace(0.05, 50.0, 21)
"""Grid of the rms over all readings that an unlisted law makes, in noises; each alike (log-uniform)."""
TYPICAL_COMPLIANCE = 2e-6
"""rad/(N·m), the joint compliance of the robots whose effects the catalogue calls typical …"""
TYPICAL_TORQUE = 1e3
"""… and the torque, N·m, that their joints carry."""
BEND = 0.2
"""Share of a spring's angle by which its curve bends at the largest torque: the catalogue's quadratic term at these."""
TYPICAL_FRICTION, TYPICAL_SPEED = 50.0, 0.5
"""N·m and rad/s: of the drives whose effects the catalogue calls typical."""

# Mistakes in the set-up and in the data, settings that are contradicted.

SETUP_MISTAKE = 0.02
"""Probability of each mistake in the set-up: a tool of which nothing is said …"""
TOOL_SIZES = np.geomspace(0.02, 1.0, 9)
"""… and grid of its mass over the weight that the largest force is, each alike (log-uniform) …"""
LEVER_OF_TOOL = 0.1
"""… and how far from the flange its centre lies, m."""
CONTRADICTED = 0.05
"""Probability that a setting is contradicted: a parameter that is held, the first-order balance, a given frame."""
DOUBTED_RUN = 0.01
"""Probability that a run is off: mislabelled, knocked, in another unit …"""
DOUBTED_ROW = 0.001
"""… and that a single reading is …"""
RUN_SIZES = np.geomspace(2.0, 5000.0, 21)
"""… and grid of the rms by which they are, in noises; each alike (log-uniform)."""
LOUDER = np.geomspace(2.0, 8.0, 5)
"""Grid of the noise that a louder run has besides, in noises, each alike (log-uniform): less is a tail of the noise."""
LEAST_ALONE = 3
"""States of a run from which on one of them is off alone; of fewer the run is."""
FAR = 3.0
"""Noises from which on a reading may be off: what lies nearer has less evidence than it is improbable.
Ours: −0.136 (a single reading), +0.004.
"""
SET_ASIDE = 0.5
"""Probability of being off from which on a run takes no part: more probable than not."""
INSTEAD = 4.0
"""Nats behind the best set up to which an effect explains what is off nearly as well. Ours: 0, 0."""

# Noise, and the discrepancy that every hypothesis carries.

STATED_NOISE_DOF = 4.0
"""Degrees of freedom about noise that is only stated."""
NORMAL = 0.5
"""Probability that single readings scatter normally …"""
TAILS = np.array([10.0, 5.0, 3.0])
"""… and degrees of freedom of the t distribution that they have else, each alike."""
LEAST_WORTH = 0.01
"""What a plain square is worth of one of normal noise, where its variance is infinite."""
DISCREPANCIES = np.geomspace(0.17, 8.0, 16)
"""Grid of the discrepancy of every hypothesis, in noises, each alike (log-uniform): middles of what lies between 0.15
and 9. Less shows nowhere; of sizes from 0.05 on it is a fifth, which counts as none.

Summed along a spline (`stiffcal.judgement.size_grids`): as a plain sum over these a wander of 400 directions lost up to
4.6 nats by where its size lies between two of them.
"""
NO_DISCREPANCY, OF_LOADS, OF_TIME = 0.6, 0.28, 0.12
"""… and how probable it is that there is none, that poses answer their loads in ways of their own, that they wander."""
LINGERS = np.array([0.2, 0.35, 0.5, 0.6, 0.7])
"""Grid of the share of a reading's noise that is left in the next, each alike: of 0.7 a twentieth is left after eight
readings …"""
LINGERING = 0.12
"""… and how probable it is that noise lingers: as `OF_TIME`. Ours."""
LOADED = 5.0
"""Noises of a wrench's components from which on it is one; less is none, read with noise. Ours."""
SHOWS_ITS_NOISE = 50.0
"""Readings of a run, its constants taken out, that show its noise to a tenth: from so many on it may be louder.
Ours: 0, 0.
"""

# Functions of which laws that nobody has written down are sums.

USUAL_LOAD, BEYOND_USUAL = 0.9, 2.0
"""Quantile of the loads that counts as one, and how far beyond it a law's functions go on.
Ours, the second: −0.001, −0.003.
"""
LEVER_OF_NODE = 0.1
"""m of a shift for a radian of a turn: as large at the tool as each other. Ours: 0, 0."""
STEPS = (3.0, 10.0, 40.0)
"""How steep a joint's law may be at zero, over the usual load."""
WARMING = (5.0, 15.0)
"""Time constants over the time of a campaign: what warms up within a fifth and a fifteenth of it."""
THRESHOLDS, WIDTH_OF_STEP = (0.3, 0.6, 0.9), 0.1
"""Forces over the usual one from which a part of the set-up may slip, and how wide such a step is over it."""
AVERAGES = (2.0, 6.0, 20.0)
"""States over which what was carried is forgotten."""
STILL = 0.02
"""Change of the load, over the usual one, below which it has not turned. Ours: −0.020, +0.003."""
WAVES = 20
"""Half waves over a run of a random walk."""
MOST_OF_RUN = 42
"""Directions of one run alone: six loads and a step for each of six components."""
LEAST_MASS = 1.0
"""kg, on which a first moment acts where a link has less mass: its centre of mass stays within metres."""

MOTION_WAVES = 8
"""Half waves over all that a moving joint goes through."""
MOTION_POWERS = 6
"""Degree of a curve over speed."""
FORGOTTEN = (3.0, 10.0, 30.0, 100.0)
"""s over which what a joint did before is forgotten."""

# Where an answer begins.

NAMED, FIRM = 0.5, 0.95
"""Probability from which a group is named, and from which it is firm."""
STILL_FIRM = 0.8
"""Probability that a firm name keeps when any prior is three times larger or smaller."""
PRIOR_FACTOR = 3.0
"""By which each prior is varied."""
ALIKE = 0.95
"""Share of an effect's length that another can make, from which the two are one group."""
ALTERNATIVES = 0.95
"""Other effects of a group are named until together with the first they have so much of it."""
DOUBT = 0.05
"""Probability of an unlisted law in its place that leaves an effect no firm name."""
SHARED = 0.5
"""Share of an effect's squares that an unlisted law makes, from which it can be in its place."""
SHOWS = 0.5
"""Of the noise, rms over all readings: what shows less is nothing …"""
SCATTERS = 1.0
"""… and of the scatter between absolute places, which is the noise of their instrument where nothing was repeated."""
CHANCE = 0.003
"""Probability below which what is left is no chance: of three checks one fails in a hundred sound campaigns."""
POWER = 1.2816
"""Standard deviations that nine of ten lie below."""
MOST_UNDECIDED = 4
"""Effects of an undecided group that are listed."""
CURVE_POINTS = 15
"""Points of the curve of a law, each a mean over as many states."""
LEAST_LOADED = 0.1
"""Of a joint's largest load: with less its compliance does not show."""
FEW_POSES = 6
"""Poses below which the error in those left out is poorly determined."""

# How far sets and shapes are sought.

MODELS = 6
"""Models about which the members are compared, at most."""
RUNS_KEPT = 8
"""Runs that may be off and are compared with all else: those that explain most by being so. Ours: 0, 0."""
ROWS_KEPT = 12
"""States that are compared with all else, those that are furthest off."""
WITHIN = 9.0
"""Nats behind the best set up to which a set is enlarged."""
OUT_OF_REACH = 40.0
"""Nats behind the best set, for normal noise, from which on a set has the tails of that."""
CLOSE = 12
"""Additions to a set that are weighed exactly: those that gain most next to it."""
MOST_NEW_EFFECTS, MOST_NEW_LAWS, MOST_NEW_MISTAKES, MOST_NEW_ROWS, MOST_NEW_SETUPS, MOST_NEW_SETTINGS = 2, 1, 3, 6, 1, 2
"""Members of a set beyond those of the model: columns are straight lines, and next to what is large others bend."""
MOST_EXPANDED = 14
"""Sets that are enlarged."""
SWEEPS = 3
"""Times that each member's size is sought again while the others stay."""
RIVALS_WITHIN = 25.0
"""Nats behind the best set up to which a rival is refitted: what an effect of ten noises bends, and more."""
MOST_REFITS = 8
"""Rivals that are refitted."""
VARIED_WITHIN = 6.0
"""Nats behind the best set up to which sets are weighed anew: a factor of three in a size is worth two of them."""
KNOWN_IN_PLACES = 2.0
"""Nats that an effect gains alone from which on its value is known well enough to be looked for in places.
Ours: 0, 0.
"""
LEAST_LIKELY = 1e-4
"""Probability below which a set counts as none where it is asked whether anything shows."""
ALL_SHAPES = 200
"""Combinations of shape parameters up to which a law is tried."""
SHAPE_STAYS = 0.3
"""Nats by which evidence may differ between neighbours at the best shape."""
SHAPE_ROUNDS = 5
"""Times that a grid is made finer."""
HOPELESS = 4.0
"""Nats behind the model without the effect from which on its grid is left as it is."""
MOST_BINS = 500
"""Means that a moving joint is judged by: more show nothing else, and cost time."""
SHAPES_TOGETHER = 8
"""Shapes whose inner products are made at once: those with each other are of no use."""
TAILS_WITHIN = 4.0
"""Nats behind a set's best discrepancy up to which the tails of what it leaves are found."""

# Computation: rounding, steps of differences, memory. Answers do not depend on them.

ROUNDING = 1e-10
"""Share of an inner product below which it is rounding."""
LEAST_FREE = 1e-3
"""Share of a reading that is left free, below which it shows nothing."""
LEAST_LEFT = 1e-6
"""Share of an effect's squares that is left beyond what every hypothesis can make, below which it does not show."""
LEAST_DIRECTION = 1e-9
"""Share of the largest variance of a run below which a direction is rounding."""
SAME_VALUE = 1e-9
"""Share of its range by which a value may change that stays."""
BINS, BIN_RANGE = 320, (-12.0, 20.0)
"""Bins of log ε̂²/f, and where they begin and end."""
OF_CELL, LEAST_OF_SPLINE = 4, 4
"""Parts of the cell of a size over which evidence is summed, and sizes through which a cubic spline is laid."""
SCALE_PASSES, SIZE_PASSES = 12, 50
"""Steps in which a scale of the noise, and an excluded size, is found …"""
SIZE_FOUND = 1e-9
"""… and share of it by which an excluded size may still change."""
DIFFERENCE_STEP = 1e-3
"""Of a parameter's typical size, of its numerical derivative."""
STEP_MASS, STEP_MOMENT = 10.0, 10.0
"""kg and kg·m of the differences."""
NUMBERS_AT_ONCE = 1 << 20
"""Of columns that are reduced together: 8 MB."""
DIRECTIONS_AT_ONCE = 1 << 11
"""Of inner products along directions: of twenty columns and all sizes these stay in the processor's cache."""
LARGE_FACTOR = 10
"""Columns from which on it takes less time to make triangular inverses one by one than whole ones at once."""
MOST_KEPT = 1 << 21
"""Numbers of reduced columns that are kept for sets to come: 16 MB …"""
MOST_SPLIT = 1 << 23
"""… and of the parts of members that are in sets with others: 64 MB."""
ALIKE_IN_SWEEPS = 0.28
"""How probable it is that the states of a sweep err alike wherever the motor stands alike: as `OF_LOADS`. Ours."""
PASS = 3
"""States in one sense that are at least a pass of a sweep; fewer are the motor's noise where it turns. Ours."""
WORTH_OF_NEIGHBOURS = 0.5
"""Independent squares for one distance of a reading from the line through its neighbours, 1 / 1.94 where even."""
LEAST_SQUARE = 1e-12
"""Squares below, in noises, are those of readings that were rounded alike: no noise is known from them. Ours."""
LEAST_STATES = 80
"""States of a run that show its noise to about a ninth; shorter ones have that which is stated. Ours."""
TO_JUDGE, TO_SCAN = 0.85, 0.97
"""Of the progress of a diagnosis, what is done when effects are compared, and when each one's held-out error is there.

Of the first the first model has half, each later one half of what is left, as how many there will be is not known.
"""
OF_CANDIDATES = 0.25
"""Of the progress about one model, what the columns of candidates take; the rest are sets of them."""
OF_SINGLES, FEWER = 0.3, 0.8
"""Of the progress of a search, what single members take; each set that is enlarged leaves this share of the rest."""

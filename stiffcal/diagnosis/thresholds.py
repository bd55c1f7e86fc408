"""Every threshold of the diagnosis, in one place, each with where it comes from."""

from __future__ import annotations

# HeldoutResiduals error within this multiple of the noise is as good as the instruments (physics, section 5.1).
ADEQUATE_RATIO = 1.05
# The lack of fit must be as sure as this before something is called missing on its ground alone: with one campaign in
# a hundred judged wrongly the rest of the two per cent allowed for false alarms is left to the candidates.
LACK_OF_FIT_P = 0.005
# A candidate is supported where the held-out error falls by more than this share of the noise … (section 5.3)
LEAST_FALL = 0.01
# … and by more than this many standard errors over poses …
STANDARD_ERRORS = 2.0
# … and the family-wise p is below this.
FAMILY_P = 0.01
# Candidates whose held-out error lies within this many standard errors of the best look alike (section 5.4).
LOOK_ALIKE_ERRORS = 2.0
# So many standard deviations a normal number is hardly ever off: one in 16 000.
FARTHEST_NORMAL = 4.0
# Below this share of the noise nobody can measure a difference in held-out error: candidates closer than
# this look alike, however small the standard error is.
LOOK_ALIKE_SHARE = 0.005
# Folds of fewer rows than the columns' number over this are left out by what their few rows change: less work so.
FEW_ROWS = 3
# What is left of a column beyond those before it, of unit length, that is rounding.
DEPENDENT = 1e-9
# Of fewer runs no two can be left out, …
RUNS_FOR_PAIRS = 4
# … from so many on two may be faulty, …
RUNS_FOR_TWO = 8
# … and of fewer places than this no turn is found.
LEAST_PLACES = 3
# Runs point against their loads where more than this share of all points along them.
MOST_ALONG = 0.5
# So many other dependences that explain what is left as well are listed: of more nobody can choose.
MOST_ALTERNATIVES = 4
# A set of effects that explains less than this share of the avoidable error is part of the answer at most (section
# 5.6): half of a structure is easily mimicked by a wrong effect (61 % by the best wrong one on practice 09) …
LEAST_EXPLAINED = 0.8
# Resamplings of poses behind `explained_share`.
RESAMPLINGS = 400
# The choice is repeated in at most this many folds: each holds at least a tenth of the poses.
CHOICE_FOLDS = 10
# Effects with more values of a discrete shape than this are scanned by steps inside runs, not by refits.
MANY_SHAPES = 60
# Noise that lingers from reading to reading for less than this many of them is noise; beyond, the target wanders. A
# correlation of 0.6 from one reading to the next has died away to 2 %, a random walk has hardly begun.
LINGERING = 8
# Correlation of successive residuals beyond which this is reported: uncertainties are then too small by a fifth or
# more.
REPORTED_LINGERING = 0.2
# A set-up error whose fitted value differs from what absolute places show by more than so many standard errors is not
# supported: with a handful of such candidates one campaign in a hundred would lose a right one.
PLACES_ERRORS = 3.0
# Of torque over motion each combination of shapes costs a refit of some hundred rows: all orders of a ripple are tried.
MANY_ROW_SHAPES = 2000
# What is left out in turn: with fewer speeds or seconds of motion nothing is judged.
LEAST_FOLDS = 3

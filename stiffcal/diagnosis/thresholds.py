"""Every threshold of the diagnosis, in one place, each with where it comes from."""

from __future__ import annotations

# HeldoutResiduals error within this multiple of the noise is as good as the instruments (physics, section 5.1).
ADEQUATE_RATIO = 1.05
# The lack of fit must be as sure as this before something is called missing on its ground alone: with one campaign in
# a hundred judged wrongly the rest of the two per cent allowed for false alarms is left to the candidates.
LACK_OF_FIT_P = 0.005
# A candidate is supported where the unseen error falls by more than this share of the noise … (section 5.3)
LEAST_FALL = 0.01
# … and by more than this many standard errors over poses …
STANDARD_ERRORS = 2.0
# … and the family-wise p is below this.
FAMILY_P = 0.01
# Candidates whose unseen error lies within this many standard errors of the best look alike (section 5.4).
LOOK_ALIKE_ERRORS = 2.0
# Below this share of the noise a difference in unseen error is nothing that anyone can measure: candidates closer than
# this look alike, however small the standard error is.
LOOK_ALIKE_SHARE = 0.005
# A set of effects that leaves more than this share of the avoidable error is no explanation (section 5.6): half of a
# structure is easily mimicked by a wrong effect (measured on practice 09: 61 % by the best wrong one), nine tenths not.
LEAST_EXPLAINED = 0.9
# How many effects are looked for, one after another: three are asked for, one more shows that nothing is left.
MOST_EFFECTS = 5
# Of all pairs of candidates, those that lower the fit's squares most are judged in unseen poses; effects with more
# amplitudes than this take no part: with so many numbers a pair can mimic anything.
PAIRS_SCORED = 12
WIDEST_PAIR = 6
# Resamplings of poses behind `confidence`.
RESAMPLINGS = 400
# The choice is repeated in at most this many folds: each holds at least a tenth of the poses.
CHOICE_FOLDS = 10
# Effects with more values of a discrete shape than this are scanned by steps inside runs, not by refits.
MANY_SHAPES = 60
# Noise that lingers from reading to reading for less than this many of them is noise; beyond, the target wanders. A
# correlation of 0.6 from one reading to the next has died away to 2 %, a random walk has hardly begun.
LINGERING = 8
# Correlation of successive residuals beyond which this is told: uncertainties are then too small by a fifth or more.
REPORTED_LINGERING = 0.2
# For so many look-alikes of the first missing effect a measurement is looked for that separates them.
PAIRS_PLANNED = 3
# What of a simpler effect's unit columns may be left beside those of one that holds it as a special case: one percent.
# The deformed robot's levers differ by less (a joint's whole compliance and the bending of the link behind it: 0.4 %).
SPECIAL_CASE = 0.01

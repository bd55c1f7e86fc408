"""What may be wrong with data: one class for each mistake, and the engine that takes it back and looks.

A mistake is one file in `catalogue/`, found by walking: it says what it changes, on what it is tried, how the data are
without it, how that reads in a fault, and what distinguishes it from mistakes that are alike. Where it is tried, the
data judge: `displacements/` by what joint springs explain of a table, `absolute/` by joint angles and places that meet,
of a whole table or of some of its rows, `references/` by kinematics that meets the tracker in the unloaded poses.
Nothing is corrected: the one change with which the data agree is named.
"""

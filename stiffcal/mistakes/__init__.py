"""What may be wrong with data: one class for each mistake, and the engines that take them back and look.

A mistake is one file in `catalogue/`, found by walking: it states the ways in which the data would be without it
(`Mistake.ways`), how each reads, and what distinguishes it from mistakes that are alike. Where it is tried, the data
judge, and its base class stands there: `inputs/` (tables, manifest, robot file), `runs/`, `rods/`, `clocks/`,
`states/`, `places/`. Of what is read, `displacements/` judges by what joint springs explain of a table, `absolute/` by
joint angles and places that meet, of a whole table or of some of its rows, `references/` by kinematics that meets the
tracker in the unloaded poses. Nothing is corrected: the one change with which the data agree is named.
"""

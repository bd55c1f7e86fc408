"""Force sensors whose zero moved within a run or a table: from which row on, by how much, and what it does.

It is no mistake of the catalogue: what is taken back is a step or a course with a place in time of its own, and which
of the accounts holds is judged within one run, by the unloaded readings and by how the motion follows the loads.
"""

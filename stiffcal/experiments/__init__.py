"""Room for what is particular to one kind of experiment: which side of the balance it knows, which it looks for.

In a load campaign the wrench and the joint angles are known and the deflection is measured; a clamped robot knows its
(zero) motion and measures the reaction. Both are sides of one equation. As long as load campaigns are the only kind,
those sides are written down where they are used, in `stiffcal.identification.observation`, and this room is empty.
"""

"""One plain function per command: what a notebook calls, and what the command line shows.

Each takes a campaign folder and returns the command's result; steps that are missing or stale are run first. Where a
result is not a type of its own yet it is the command's JSON document (interface, section 4) as a plain dict.

Examples
--------
>>> from stiffcal.commands.effects import describe_effects
>>> [effect.place for effect in describe_effects("joint-compliance").effects]
['joints']
"""

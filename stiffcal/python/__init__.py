"""What `import stiffcal` offers to scripts and notebooks: a campaign as an object, its answers as tables.

Every method calls the function of `stiffcal.commands` that the command of the same name calls, on the same store.
"""

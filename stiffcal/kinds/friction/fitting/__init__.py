"""Friction rows, their noise and unknowns, the fit joint by joint, and what it cannot determine."""

"""Readings that nothing explains, and targets that were not measured, before any model."""

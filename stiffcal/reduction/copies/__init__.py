"""Readings that stand in a campaign more than once: rows, logs, rounded or as they are."""

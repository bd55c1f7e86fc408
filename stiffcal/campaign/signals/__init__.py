"""The signals that a source can hold, and the rows of it that they keep."""

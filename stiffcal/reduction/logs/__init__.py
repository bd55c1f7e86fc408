"""A source's log as it streams past: signals in SI, averaged, and what of it cannot be."""

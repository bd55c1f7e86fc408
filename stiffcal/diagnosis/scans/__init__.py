"""The catalogue as additions to a model, scored on held-out poses."""

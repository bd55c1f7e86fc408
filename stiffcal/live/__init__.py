"""The page of `view` with a server on this machine: effects are ticked, and the model is fitted again."""

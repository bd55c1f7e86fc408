"""What the load did from state to state, and whether that is enough."""

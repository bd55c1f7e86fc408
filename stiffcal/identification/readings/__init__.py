"""What was read of load states and places, as rows with their layout; kinds of states."""

"""The fit of load states and places, from the start to what it determines."""

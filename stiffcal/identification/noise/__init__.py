"""Noise of readings and of wrenches, and the weights that follow from it."""

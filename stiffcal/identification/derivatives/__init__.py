"""Predicted readings and their derivatives by parameters, geometry and frames, through the balance."""

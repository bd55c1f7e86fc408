"""Rods on links that contradict each other, or the load: judged by what is left of the contradiction."""

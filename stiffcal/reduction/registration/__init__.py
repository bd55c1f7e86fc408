"""Frames that the manifest leaves to be found, from unloaded poses and joint angles."""

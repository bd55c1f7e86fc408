"""Unloaded poses, judged by kinematics that meets the tracker."""

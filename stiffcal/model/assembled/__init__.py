"""The robot with its effects placed and valued, and the frames that are found with it."""

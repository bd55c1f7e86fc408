"""What is wrong with a manifest as a whole, or only next to robot, model and folder."""

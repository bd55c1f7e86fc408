"""Programs that move a robot from run to run of a plan: a file for each language of a controller."""

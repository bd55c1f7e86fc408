"""Torque against angle of one driven joint: branches, spring, play and friction fitted to them."""

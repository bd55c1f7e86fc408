"""What laws of several effects are made of: curves, memories, drives."""

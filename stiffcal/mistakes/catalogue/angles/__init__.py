"""Mistakes in joint angles: units, columns, directions, zeros, angles counted together."""

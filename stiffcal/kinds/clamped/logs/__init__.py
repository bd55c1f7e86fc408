"""From logs of clamped runs to readings: clocks brought together, sweeps cut into cycles."""

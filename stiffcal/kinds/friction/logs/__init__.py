"""From logs of friction runs to readings on one clock."""

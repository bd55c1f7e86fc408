"""The clamped chain as a whole: what holds it, what its drives carry, what contradicts itself."""

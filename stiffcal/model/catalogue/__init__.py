"""The effects that can be tried: found in their folder, and in the campaign's own code."""

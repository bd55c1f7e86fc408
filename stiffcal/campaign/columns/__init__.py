"""What names of columns say: quantity, axis, unit, joint."""

"""What is wrong with logs while they are read: no signal, another unit, too short, not listed."""

"""What a person writes: manifest, robot file and model file, typed; this package names no effect."""

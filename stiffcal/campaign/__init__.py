"""What a person writes: manifest, robot file and model file, typed; this room names no effect."""

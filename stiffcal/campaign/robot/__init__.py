"""robot.toml and the URDF that it may name: geometry, couplings, masses, shapes."""

"""stiffcal: find out how an industrial robot bends, and which physical effect the model lacks."""

__version__ = "0.1.0"

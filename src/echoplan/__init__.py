"""Floor plans from echoes: maps of walls, corners and cylinders from cheap ultrasonic sensors."""

__version__ = "0.1.0"

__all__ = ["__version__"]

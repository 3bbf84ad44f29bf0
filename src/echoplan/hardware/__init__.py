"""Devices with ultrasonic sensors: their protocol, how they are reached, and the sweeps that they make."""

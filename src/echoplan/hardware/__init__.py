"""Devices with ultrasonic sensors: their protocol, how they are reached, and the sweeps that they make."""

from echoplan.hardware.driver import Device, find_device
from echoplan.hardware.messages import Echo
from echoplan.hardware.port import port_names
from echoplan.hardware.source import DeviceSource

__all__ = ["Device", "DeviceSource", "Echo", "find_device", "port_names"]

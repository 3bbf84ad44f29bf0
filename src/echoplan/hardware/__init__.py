"""Devices with ultrasonic sensors: their protocol, how they are reached, and the sweeps that they make."""

from echoplan.hardware.driver import Device, find_device
from echoplan.hardware.port import is_device, port_names
from echoplan.hardware.protocol import Echo, Record
from echoplan.hardware.source import DeviceSource

__all__ = ["Device", "DeviceSource", "Echo", "Record", "find_device", "is_device", "port_names"]

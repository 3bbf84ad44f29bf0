"""A device as a source of sweeps, like a recording or the simulator."""

from collections.abc import Iterator
from dataclasses import dataclass, field

from echoplan.hardware.driver import Device
from echoplan.model import Conventions, Rig, Sweep

__all__ = ["DeviceSource"]


@dataclass(frozen=True, slots=True, kw_only=True)
class DeviceSource:
    """A source that makes sweeps while it is read, where the robot stands.

    Parameters
    ----------
    name : str
        Address of the device.
    rig : Rig
        Its sensors.
    count : int, optional
        Number of sweeps.
    conventions : Conventions, optional
        How its servo angles are counted.
    """

    name: str
    rig: Rig
    count: int = 1
    conventions: Conventions = field(default_factory=Conventions)

    def __len__(self) -> int:
        return self.count

    def __iter__(self) -> Iterator[Sweep]:
        """Yield the sweeps.

        Raises
        ------
        InputError
            If the device does not answer, or the rig does not fit it.
        """
        with Device(self.name) as device:
            yield from map(self.conventions.apply, device.sweeps(self.count, rig=self.rig))

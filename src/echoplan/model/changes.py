"""Changes of a place between the recordings of a map."""

from dataclasses import dataclass

from echoplan.arrays import FloatArray, checked_floats, store
from echoplan.model.features import Cylinder

__all__ = ["Changes"]


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Changes:
    """What one recording found gone from a place, compared with the map of those before it, and what is new.

    Parameters
    ----------
    recording : str, optional
        Name of the recording.
    first_sweep : int, optional
        Number of its first sweep; None if it is not known.
    gone_walls, new_walls : tuple of ndarray, shape (2, 2), optional
        Ends of walls, or of pieces of walls [m].
    gone_cylinders, new_cylinders : tuple of Cylinder, optional
        Cylinders.

    Raises
    ------
    InvalidValueError
        If a coordinate is not finite.
    """

    recording: str = ""
    first_sweep: int | None = None
    gone_walls: tuple[FloatArray, ...] = ()
    new_walls: tuple[FloatArray, ...] = ()
    gone_cylinders: tuple[Cylinder, ...] = ()
    new_cylinders: tuple[Cylinder, ...] = ()

    def __post_init__(self) -> None:
        for name in ("gone_walls", "new_walls"):
            ends = tuple(checked_floats(each, name=name, shape=(2, 2)) for each in getattr(self, name))
            store(self, **{name: ends})

    def __bool__(self) -> bool:
        """Whether anything has changed."""
        return bool(self.gone_walls or self.new_walls or self.gone_cylinders or self.new_cylinders)

"""A map from which the map of another recording goes on: ``map.json`` with ``prior.npz`` beside it."""

from dataclasses import astuple, dataclass
from hashlib import sha256
from os import PathLike, fspath
from pathlib import Path

import numpy as np

from echoplan.arrays import FloatArray, checked_floats
from echoplan.errors import InputError, InvalidValueError
from echoplan.io import read_arrays, read_map, write_arrays
from echoplan.joint.marginal_prior import MarginalPrior
from echoplan.joint.saved_prior import arrays_of, prior_of_arrays
from echoplan.model import FeatureMap, Rig

__all__ = ["PRIOR", "StartingMap", "read_start", "sensors_of", "write_prior"]

PRIOR = "prior.npz"
# Version of the arrays; others are refused.
_VERSION = 3.0
_REMEDY = "make the map again with echoplan map"


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class StartingMap:
    """What is known of a place before a recording.

    Parameters
    ----------
    feature_map : FeatureMap
        The map.
    prior : MarginalPrior
        Its landmarks with their joint information, in a local frame.
    origin_xy : ndarray, shape (2,)
        Origin of the local frame in the frame of the map [m].
    sensors : ndarray, shape (n, 7)
        Sensors of its recordings, as ``sensors_of`` returns them: noise and range scale are theirs.
    """

    feature_map: FeatureMap
    prior: MarginalPrior
    origin_xy: FloatArray
    sensors: FloatArray


def sensors_of(rig: Rig) -> FloatArray:
    """Return what identifies the sensors of a rig; bags show their resolutions only roughly.

    Parameters
    ----------
    rig : Rig
        The rig.

    Returns
    -------
    ndarray, shape (n, 7)
        Id, x, y, yaw, half aperture, least and greatest range [m, rad].
    """
    return np.array([astuple(each)[:-1] for each in rig.sensors], dtype=np.float64)


def read_start(path: str | PathLike[str]) -> StartingMap:
    """Read a map from which another one is to go on.

    Parameters
    ----------
    path : str or Path
        The folder of the map, or its ``map.json``.

    Returns
    -------
    StartingMap
        The map.

    Raises
    ------
    InputError
        If a file is missing, cannot be read or does not fit.
    """
    if Path(path).is_file() and Path(path).suffix != ".json":
        raise InputError(fspath(path), "it is no map", remedy="name the folder of a map, or its map.json")
    feature_map = read_map(path)
    file = Path(path) / "map.json" if Path(path).is_dir() else Path(path)
    beside = file.parent / PRIOR
    if not beside.exists():
        problem = "it is missing: the map was made by another method than joint, or by an older version"
        raise InputError(beside, problem, remedy=_REMEDY)
    arrays = read_arrays(beside)
    if arrays.get("version", np.zeros(0)).tolist() != [_VERSION]:
        raise InputError(beside, "it is of another version", remedy=_REMEDY)
    if arrays.get("map_digest", np.zeros(0)).tolist() != _digest_of(file):
        raise InputError(beside, f"it is of another map than {file.name}, or one of them was changed", remedy=_REMEDY)
    try:
        origin_xy = checked_floats(arrays.get("origin", np.zeros(0)), name="origin", shape=(2,))
        sensors = checked_floats(arrays.get("sensors", np.zeros(0)), name="sensors", shape=(None, 7))
        return StartingMap(feature_map=feature_map, prior=prior_of_arrays(arrays), origin_xy=origin_xy, sensors=sensors)
    except InvalidValueError as error:
        raise InputError(beside, str(error), remedy=_REMEDY) from None


def write_prior(folder: Path, known: StartingMap) -> None:
    """Write what another recording needs to go on from the ``map.json`` of a folder."""
    digest = np.array(_digest_of(folder / "map.json"), dtype=np.float64)
    arrays = {
        "version": np.array([_VERSION]),
        "map_digest": digest,
        "origin": known.origin_xy,
        "sensors": known.sensors,
        **arrays_of(known.prior),
    }
    write_arrays(folder / PRIOR, arrays)


def _digest_of(file: Path) -> list[int]:
    """Return the SHA-256 digest of a file."""
    return list(sha256(file.read_bytes()).digest())

"""A map from which the map of another recording goes on: ``map.json`` with ``prior.npz`` beside it."""

from dataclasses import dataclass
from os import PathLike
from pathlib import Path

import numpy as np

from echoplan.arrays import FloatArray, checked_floats
from echoplan.errors import InputError, InvalidValueError
from echoplan.io import read_arrays, read_map, write_arrays
from echoplan.joint.marginal_prior import MarginalPrior
from echoplan.joint.saved_prior import arrays_of, prior_of_arrays
from echoplan.model import FeatureMap

__all__ = ["PRIOR", "KnownPlace", "read_start", "write_prior"]

PRIOR = "prior.npz"
# Version of the arrays; others are refused.
_VERSION = 1.0


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class KnownPlace:
    """What is known of a place before a recording.

    Parameters
    ----------
    feature_map : FeatureMap
        The map.
    prior : MarginalPrior
        Its landmarks with their joint information, in a local frame.
    origin_xy : ndarray, shape (2,)
        Origin of the local frame in the frame of the map [m].
    """

    feature_map: FeatureMap
    prior: MarginalPrior
    origin_xy: FloatArray


def read_start(path: str | PathLike[str]) -> KnownPlace:
    """Read a map from which another one is to go on.

    Parameters
    ----------
    path : str or Path
        The folder of the map, or its ``map.json``.

    Returns
    -------
    KnownPlace
        The map.

    Raises
    ------
    InputError
        If a file is missing, cannot be read or does not fit.
    """
    feature_map = read_map(path)
    beside = (Path(path) if Path(path).is_dir() else Path(path).parent) / PRIOR
    if not beside.exists():
        problem = "it is missing: the map was made by another method than joint, or by an older version"
        raise InputError(beside, problem, remedy="make the map again with echoplan map")
    arrays = read_arrays(beside)
    if arrays.get("version", np.zeros(0)).tolist() != [_VERSION]:
        raise InputError(beside, "it is of another version", remedy="make the map again with echoplan map")
    try:
        origin_xy = checked_floats(arrays.get("origin", np.zeros(0)), name="origin", shape=(2,))
        return KnownPlace(feature_map=feature_map, prior=prior_of_arrays(arrays), origin_xy=origin_xy)
    except InvalidValueError as error:
        raise InputError(beside, str(error), remedy="make the map again with echoplan map") from None


def write_prior(path: Path, prior: MarginalPrior, *, origin_xy: FloatArray) -> None:
    """Write what another recording needs to go on from a map."""
    write_arrays(path, {"version": np.array([_VERSION]), "origin": origin_xy, **arrays_of(prior)})

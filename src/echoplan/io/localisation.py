"""Localisations in JSON: ``localisation.json``."""

from dataclasses import asdict
from pathlib import Path

from echoplan.arrays import IntArray
from echoplan.io.files import by_name, write_text
from echoplan.io.text import format_json
from echoplan.model import Localisation, Quality

__all__ = ["write_localisation"]


@by_name
def write_localisation(path: Path, localisation: Localisation, *, stamps_ns: IntArray, quality: Quality) -> None:
    """Write the poses of a recording in a map.

    Parameters
    ----------
    path : Path or str
        The file.
    localisation : Localisation
        The poses, and the alternatives to the first one.
    stamps_ns : ndarray of int, shape (s,)
        When the robot was at each pose [ns].
    quality : Quality
        Whether the poses can be trusted.

    Raises
    ------
    OutputError
        If the file cannot be written.
    """
    rows = zip(
        localisation.sweeps.tolist(),
        stamps_ns.tolist(),
        localisation.poses.tolist(),
        localisation.covariances.tolist(),
        strict=True,
    )
    segments = [
        {
            "first_sweep": each.first,
            "is_ambiguous": each.is_ambiguous,
            "starts": [
                {**dict(zip(("x", "y", "yaw"), start.pose.tolist(), strict=True)), "weight": start.weight}
                for start in each.starts
            ],
        }
        for each in localisation.segments
    ]
    document = {
        "format": "echoplan-localisation/1",
        "frame": "map",
        "quality": asdict(quality),
        "inlier_ratio": localisation.inlier_ratio,
        "jaccard_index": localisation.jaccard_index,
        "segments": segments,
        "poses": [
            {"sweep": sweep, "stamp_ns": stamp, "x": x, "y": y, "yaw": yaw, "covariance": covariance}
            for sweep, stamp, (x, y, yaw), covariance in rows
        ],
    }
    write_text(path, format_json(document) + "\n")

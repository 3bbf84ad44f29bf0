"""Routes in CSV: stations ``x,y,yaw``, or a way ``t,x,y,yaw``."""

from pathlib import Path

import numpy as np

from echoplan.errors import InputError, InvalidValueError
from echoplan.io.files import by_name, write_text
from echoplan.io.kinds import ANGLE, POSITION, SECONDS
from echoplan.io.table import Table
from echoplan.io.text import format_seconds
from echoplan.io.units import check_extent, looks_like_degrees
from echoplan.model import Route

__all__ = ["read_route", "write_route"]

_COLUMNS = {"t": SECONDS, "x": POSITION, "y": POSITION, "yaw": ANGLE}


@by_name
def read_route(path: Path) -> Route:
    """Read a route.

    Parameters
    ----------
    path : Path or str
        The file; a column ``t`` makes it a way, without it there are stations.

    Returns
    -------
    Route
        The route.

    Raises
    ------
    InputError
        If the file cannot be read or describes no possible route.
    """
    table = Table.open(path, _COLUMNS, optional=["t"])
    rows = np.concatenate([rows.data for rows in table])
    if looks_like_degrees(rows["yaw"]):
        raise InputError(path, "the angles look like degrees", place="column yaw", remedy="write radians")
    poses = np.stack([rows["x"], rows["y"], rows["yaw"]], axis=1)
    try:
        check_extent(poses[:, :2], name="the route")
    except InvalidValueError as error:
        problem, _, remedy = str(error).partition("; ")
        raise InputError(path, problem, remedy=remedy) from error
    try:
        return Route(
            map_from_base=poses,
            stamps_ns=rows["t"] if "t" in table.columns else None,
        )
    except InvalidValueError as error:
        raise InputError(path, str(error), place="column t", remedy="sort the rows by t") from error


@by_name
def write_route(path: Path, route: Route) -> None:
    """Write a route.

    Parameters
    ----------
    path : Path or str
        The file.
    route : Route
        The route.

    Raises
    ------
    OutputError
        If the file cannot be written.

    Examples
    --------
    >>> path = getfixture("tmp_path") / "route.csv"
    >>> write_route(path, Route(map_from_base=[[0.0, 0.0, 0.0], [0.5, 0.0, 1.57]]))
    >>> print(path.read_text())
    x,y,yaw
    0.0,0.0,0.0
    0.5,0.0,1.57
    <BLANKLINE>
    """
    poses = [",".join(map(repr, pose)) for pose in route.map_from_base.tolist()]
    if route.stamps_ns is None:
        lines = ["x,y,yaw", *poses]
    else:
        times = map(format_seconds, route.stamps_ns.tolist())
        lines = ["t,x,y,yaw", *(f"{time},{pose}" for time, pose in zip(times, poses, strict=True))]
    write_text(path, "\n".join(lines) + "\n")

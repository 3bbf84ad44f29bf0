"""The table of a batch: a row for each recording, as CSV and Parquet."""

from collections.abc import Sequence
from io import BytesIO
from typing import Any, Literal

from echoplan.errors import MissingExtraError
from echoplan.io.structure import Form
from echoplan.io.text import format_csv

__all__ = ["Row", "rows_csv", "rows_parquet"]


class Row(Form):
    """What a batch says of a recording; None where it is not known.

    Attributes
    ----------
    name : str
        Where the recording lies below the folder of the batch.
    status : str
        ``ok``: there is a map; ``failed``: there is none.
    error : str
        Why there is no map, in one line.
    verdict : str, optional
        Whether the map can be trusted: ``good``, ``doubtful`` or ``failed``.
    walls, corners, cylinders, openings : int, optional
        How many the map has.
    sweeps, pings : int, optional
        How many the recording has.
    seconds : float, optional
        Time for reading, mapping and checking [s].
    wall_recall, wall_precision : float, optional
        Share of the true walls that the map has, and of its walls that are right, where the truth is known.
    """

    name: str
    status: Literal["ok", "failed"]
    error: str = ""
    verdict: str | None = None
    walls: int | None = None
    corners: int | None = None
    cylinders: int | None = None
    openings: int | None = None
    sweeps: int | None = None
    pings: int | None = None
    seconds: float | None = None
    wall_recall: float | None = None
    wall_precision: float | None = None


def rows_csv(rows: Sequence[Row]) -> str:
    """Write rows as a table for a spreadsheet.

    Parameters
    ----------
    rows : sequence of Row
        The rows.

    Returns
    -------
    str
        Comma-separated values with a header; cells are empty where something is not known.
    """
    return format_csv([row.model_dump() for row in rows], columns=tuple(Row.model_fields))


def rows_parquet(rows: Sequence[Row]) -> bytes:
    """Write rows as an Apache Parquet file.

    Parameters
    ----------
    rows : sequence of Row
        The rows.

    Returns
    -------
    bytes
        The file, with the columns of ``rows_csv``; null where something is not known.

    Raises
    ------
    MissingExtraError
        If pyarrow is not installed.
    """
    try:
        import pyarrow as pa  # noqa: PLC0415 - an optional package
        from pyarrow import parquet  # noqa: PLC0415
    except ImportError as error:
        raise MissingExtraError("pyarrow", extra="cluster") from error
    types: dict[object, Any] = {int | None: pa.int64(), float | None: pa.float64()}
    schema = pa.schema([(name, types.get(each.annotation, pa.string())) for name, each in Row.model_fields.items()])
    file = BytesIO()
    parquet.write_table(pa.Table.from_pylist([row.model_dump() for row in rows], schema=schema), file)
    return file.getvalue()

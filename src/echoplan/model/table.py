"""Tables of text: what is shown on a terminal, in a report or in a document."""

from dataclasses import dataclass

from echoplan.errors import InvalidValueError

__all__ = ["Table"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Table:
    """A table of text.

    Parameters
    ----------
    title : str
        Its content.
    columns : tuple of str
        Heads of the columns, with units.
    rows : tuple of tuple of str
        The cells, row by row.

    Raises
    ------
    InvalidValueError
        If a row has more or fewer cells than there are columns.
    """

    title: str
    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]

    def __post_init__(self) -> None:
        for row in self.rows:
            if len(row) != len(self.columns):
                raise InvalidValueError(f"a row of {self.title!r} must have {len(self.columns)} cells, not {len(row)}")

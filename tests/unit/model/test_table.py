import pytest

from echoplan.errors import InvalidValueError
from echoplan.model import Table


def test_a_row_has_a_cell_for_every_column() -> None:
    assert Table(title="walls", columns=("a", "b"), rows=(("1", "2"),)).rows == (("1", "2"),)
    with pytest.raises(InvalidValueError, match="a row of 'walls' must have 2 cells, not 1"):
        Table(title="walls", columns=("a", "b"), rows=(("1",),))

"""Paper of floor plans: a standard scale, as large as the paper allows."""

import numpy as np
import pytest

from echoplan.viewer.floor_sheet import floor_sheet


@pytest.mark.parametrize(
    ("width", "height", "paper", "scale"),
    [
        (1.0, 1.0, "A4", 10.0),
        (2.0, 1.5, "A4", 20.0),
        (4.0, 3.0, "A4", 50.0),
        (8.0, 6.5, "A3", 50.0),
        (6.5, 8.0, "A4", 50.0),
        (20.0, 12.0, "A3", 100.0),
        (100.0, 60.0, "A3", 500.0),
        (9000.0, 9000.0, "A3", 50000.0),
    ],
)
def test_a_drawing_has_the_largest_standard_scale_that_fits(
    width: float, height: float, paper: str, scale: float
) -> None:
    sheet = floor_sheet(np.array([[-1.0, 2.0], [width - 1.0, height + 2.0]]), foot=32.0)
    assert (sheet.paper, sheet.scale) == (paper, scale)
    drawn = sheet.on_paper(sheet.bounds_xy)
    assert (drawn[0] >= sheet.window[0] + 20.0).all()
    assert (drawn[1] <= sheet.window[1] - 20.0).all()


def test_wide_drawings_lie_on_wide_paper() -> None:
    wide = floor_sheet(np.array([[0.0, 0.0], [4.0, 3.0]]), foot=32.0)
    high = floor_sheet(np.array([[0.0, 0.0], [3.0, 4.0]]), foot=32.0)
    assert (wide.size.tolist(), high.size.tolist()) == ([297.0, 210.0], [210.0, 297.0])


def test_a_metre_at_1_to_50_is_20_millimetres_on_paper() -> None:
    sheet = floor_sheet(np.array([[0.0, 0.0], [4.0, 3.0]]), foot=32.0)
    one, other = sheet.on_paper([[1.0, 1.0], [2.0, 1.0]])
    assert (other - one).tolist() == pytest.approx([20.0, 0.0])

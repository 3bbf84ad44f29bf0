"""Occupancy grids as pictures in a drawing: the surer a cell is, the darker if occupied and the bluer if free."""

import base64
import xml.etree.ElementTree as ET
from io import BytesIO

import numpy as np

from echoplan.arrays import FloatArray
from echoplan.model import OccupancyGrid
from echoplan.viewer.markup import element, size
from echoplan.viewer.sheet import Sheet

__all__ = ["grid_marks"]

# Colours on paper of either kind, light or dark, and how much of them is laid on for a cell that is sure.
_OCCUPIED, _FREE = (0.42, 0.45, 0.52), (0.30, 0.58, 0.90)
_MOST_OCCUPIED, _MOST_FREE = 0.85, 0.16


def grid_marks(grid: OccupancyGrid, sheet: Sheet) -> list[ET.Element]:
    """Draw the cells of a grid.

    Parameters
    ----------
    grid : OccupancyGrid
        The grid.
    sheet : Sheet
        Where it lies on paper.

    Returns
    -------
    list of Element
        One picture, a pixel a cell; what is not known is left out.
    """
    from matplotlib.image import imsave  # noqa: PLC0415 - Matplotlib is slow to import

    picture = BytesIO()
    imsave(picture, _colors(grid.values), format="png", origin="lower")
    x, y = sheet.paper(grid.origin_xy + np.array([0.0, grid.size_xy[1]])).tolist()
    width, height = (sheet.millimetres * grid.size_xy).tolist()
    data = base64.b64encode(picture.getvalue()).decode("ascii")
    place = {"x": size(x), "y": size(y), "width": size(width), "height": size(height)}
    return [element("image", href=f"data:image/png;base64,{data}", preserveAspectRatio="none", class_="cells", **place)]


def _colors(values: FloatArray) -> FloatArray:
    """Colour each cell: red, green, blue and how much of it, shape (rows, columns, 4)."""
    sure = 2.0 * values - 1.0
    colors = np.where((sure > 0)[..., None], _OCCUPIED, _FREE)
    opacity = np.where(sure > 0, _MOST_OCCUPIED * sure, -_MOST_FREE * sure)
    painted: FloatArray = np.concatenate([colors, opacity[..., None]], axis=-1)
    return painted

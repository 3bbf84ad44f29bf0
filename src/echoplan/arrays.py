"""Checked numbers and read-only arrays: what the values of the model are made of."""

import math
from dataclasses import fields, replace
from typing import TYPE_CHECKING, Any, TypeAlias, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from echoplan.errors import InvalidValueError

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

__all__ = [
    "BoolArray",
    "ComplexArray",
    "FloatArray",
    "IntArray",
    "checked_covariance",
    "checked_floats",
    "checked_integers",
    "checked_number",
    "chosen_items",
    "known_median",
    "store",
]

FloatArray: TypeAlias = NDArray[np.float64]
IntArray: TypeAlias = NDArray[np.int64]
BoolArray: TypeAlias = NDArray[np.bool_]
ComplexArray: TypeAlias = NDArray[np.complex128]

Columns = TypeVar("Columns", bound="DataclassInstance")
Shape: TypeAlias = tuple[int | None, ...]


def checked_number(
    value: float,
    *,
    name: str,
    above: float = -math.inf,
    minimum: float = -math.inf,
    maximum: float = math.inf,
) -> float:
    """Check one number against its bounds.

    Parameters
    ----------
    value : float
        The number.
    name : str
        What to call it in an error.
    above : float, optional
        The number must be greater than this.
    minimum, maximum : float, optional
        The number must lie between these, bounds included.

    Returns
    -------
    float
        The number.

    Raises
    ------
    InvalidValueError
        If it is no number, not finite or out of bounds.

    Examples
    --------
    >>> checked_number(0.1, name="radius", above=0)
    0.1
    """
    try:
        number = float(value)
    except (TypeError, ValueError) as error:
        raise InvalidValueError(f"{name} must be a number, not {value!r}") from error
    if not math.isfinite(number):
        raise InvalidValueError(f"{name} must be finite, not {number}")
    if number <= above:
        raise InvalidValueError(f"{name} must be greater than {above:.12g}, not {number:.12g}")
    if number < minimum:
        raise InvalidValueError(f"{name} must be at least {minimum:.12g}, not {number:.12g}")
    if number > maximum:
        raise InvalidValueError(f"{name} must be at most {maximum:.12g}, not {number:.12g}")
    return number


def checked_floats(value: ArrayLike, *, name: str, shape: Shape, finite: bool = True) -> FloatArray:
    """Copy a value into a read-only array of floats of a given shape.

    Parameters
    ----------
    value : array_like
        Anything NumPy turns into floats.
    name : str
        What to call it in an error.
    shape : tuple of int or None
        Expected shape; None stands for any length of that axis.
    finite : bool, optional
        Refuse ``inf`` and ``nan``.

    Returns
    -------
    ndarray of float64
        Own, read-only memory.

    Raises
    ------
    InvalidValueError
        If the value is no array of numbers of that shape, or not finite where it must be.

    Examples
    --------
    >>> checked_floats([[0, 1]], name="points_xy", shape=(None, 2))
    array([[0., 1.]])
    """
    try:
        array = np.array(value, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise InvalidValueError(f"{name} must hold numbers, not {value!r}") from error
    _check_shape(array.shape, name=name, shape=shape)
    if finite and not np.isfinite(array).all():
        bad = array[~np.isfinite(array)].flat[0]
        raise InvalidValueError(f"{name} must be finite, not {bad}")
    array.setflags(write=False)
    return array


def checked_integers(value: ArrayLike, *, name: str, shape: Shape) -> IntArray:
    """Copy a value into a read-only array of integers of a given shape.

    Parameters
    ----------
    value : array_like
        Anything NumPy turns into integers without losing a fraction.
    name : str
        What to call it in an error.
    shape : tuple of int or None
        Expected shape; None stands for any length of that axis.

    Returns
    -------
    ndarray of int64
        Own, read-only memory.

    Raises
    ------
    InvalidValueError
        If the value has a fraction, is not finite, needs more than 64 bits or has another shape.

    Examples
    --------
    >>> checked_integers([3, 4], name="sensor_ids", shape=(None,))
    array([3, 4])
    """
    try:
        given = np.asarray(value)
    except ValueError as error:
        raise InvalidValueError(f"{name} must hold whole numbers, not {value!r}") from error
    _check_shape(given.shape, name=name, shape=shape)
    if given.size and not _is_whole(given):
        raise InvalidValueError(f"{name} must hold whole numbers, not {value!r}")
    array = given.astype(np.int64)
    array.setflags(write=False)
    return array


def checked_covariance(value: ArrayLike, *, name: str, size: int) -> FloatArray:
    """Copy a value into a read-only covariance matrix.

    Parameters
    ----------
    value : array_like, shape (size, size)
        The covariance; its order and units are the caller's.
    name : str
        What to call it in an error.
    size : int
        Number of parameters.

    Returns
    -------
    ndarray of float64, shape (size, size)
        Symmetric, positive semi-definite, read-only.

    Raises
    ------
    InvalidValueError
        If the matrix is not symmetric or has a negative eigenvalue (both to rounding).

    Examples
    --------
    >>> checked_covariance([[1e-4, 0], [0, 4e-6]], name="covariance", size=2).shape
    (2, 2)
    """
    matrix = checked_floats(value, name=name, shape=(size, size))
    scale = float(np.abs(matrix).max(initial=0.0))
    if np.abs(matrix - matrix.T).max(initial=0.0) > 1e-9 * scale:
        raise InvalidValueError(f"{name} must be symmetric, not {matrix.tolist()}")
    if scale > 0 and float(np.linalg.eigvalsh(matrix / scale)[0]) < -1e-9:
        raise InvalidValueError(f"{name} must have no negative eigenvalue, not {matrix.tolist()}")
    return matrix


def chosen_items(value: Columns, chosen: BoolArray | IntArray | slice) -> Columns:
    """Keep some of the items of a value that holds nothing but arrays, each with an entry for every item.

    Parameters
    ----------
    value : dataclass
        The value.
    chosen : ndarray or slice
        A mask, indices or a slice.

    Returns
    -------
    dataclass
        One of the same kind.
    """
    return replace(value, **{field.name: getattr(value, field.name)[chosen] for field in fields(value)})


def store(value: object, /, **fields: object) -> None:
    """Set fields of a frozen dataclass from its own ``__post_init__``, with what was checked.

    Parameters
    ----------
    value : object
        The instance under construction.
    **fields : object
        The fields to set.
    """
    for name, content in fields.items():
        object.__setattr__(value, name, content)


def known_median(measured: FloatArray) -> float:
    """Return the median of what was measured.

    Parameters
    ----------
    measured : ndarray, shape (n,)
        Numbers; ``nan`` where nothing was measured.

    Returns
    -------
    float
        Their median; ``nan`` of nothing.

    Examples
    --------
    >>> known_median(np.array([19.0, np.nan, 21.0]))
    20.0
    """
    known = measured[~np.isnan(measured)]
    return float(np.median(known)) if len(known) else math.nan


def _check_shape(found: tuple[int, ...], *, name: str, shape: Shape) -> None:
    fits = len(found) == len(shape) and all(
        wanted in (None, length) for length, wanted in zip(found, shape, strict=True)
    )
    if not fits:
        wanted = ", ".join("n" if length is None else str(length) for length in shape)
        raise InvalidValueError(f"{name} must have shape ({wanted}), not {found}")


def _is_whole(array: NDArray[Any]) -> bool:
    """Return whether an array holds nothing but whole numbers that fit into 64 bits."""
    if np.issubdtype(array.dtype, np.integer):
        return bool(np.all(array <= np.iinfo(np.int64).max))
    whole = np.issubdtype(array.dtype, np.floating)
    return bool(whole and np.all((array == np.rint(array)) & (np.abs(array) < 2.0**63)))

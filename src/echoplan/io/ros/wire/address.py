"""Where a running ROS 2 is, specified in one line of text, as in ``ros2://?domain=5``."""

import os
import re
from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum
from urllib.parse import SplitResult, parse_qsl, urlsplit

from echoplan.errors import InputError, UnknownNameError

__all__ = ["Middleware", "WireAddress", "is_address", "parse_address"]


class Middleware(StrEnum):
    """What carries the messages of ROS 2."""

    DDS = "ros2"
    ZENOH = "ros2+zenoh"


# The port of a router of rmw_zenoh.
_ZENOH_PORT = 7447
# Ports of DDS are computed from the domain; higher domains have none.
_LAST_DOMAIN = 232
_LONGEST_WAIT = 86_400.0
_OPTIONS = ("domain", "wait")
_EXAMPLE = "write for example ros2://, ros2://?domain=5 or ros2+zenoh://localhost:7447"


@dataclass(frozen=True, slots=True, kw_only=True)
class WireAddress:
    """Where a running ROS 2 is.

    Parameters
    ----------
    text : str
        As the user wrote it.
    middleware : Middleware
        What carries its messages.
    host : str, optional
        A machine that takes part, for networks without multicast; with Zenoh, that of the router.
    port : int, optional
        Port of the router of Zenoh.
    domain : int, optional
        The domain of ROS 2.
    wait : float, optional
        How long to wait for topics and messages [s].
    """

    text: str
    middleware: Middleware
    host: str = ""
    port: int = _ZENOH_PORT
    domain: int = 0
    wait: float = 10.0

    @property
    def endpoint(self) -> str:
        """Host and port as in an address: IPv6 in brackets."""
        return f"[{self.host}]:{self.port}" if ":" in self.host else f"{self.host}:{self.port}"

    @property
    def is_local(self) -> bool:
        """Whether nobody but this machine takes part."""
        return self.host in ("localhost", "127.0.0.1", "::1")


def is_address(text: str) -> bool:
    """Return whether a text is meant as the address of a running ROS 2.

    Parameters
    ----------
    text : str
        What a user names as a source.

    Returns
    -------
    bool
        True by its scheme alone.

    Examples
    --------
    >>> is_address("ros2://"), is_address("run.mcap")
    (True, False)
    """
    return any(text.startswith(f"{scheme}:") for scheme in Middleware)


def parse_address(text: str, *, environment: Mapping[str, str] = os.environ) -> WireAddress:
    """Read the address of a running ROS 2.

    Parameters
    ----------
    text : str
        ``ros2://`` for DDS, ``ros2+zenoh://HOST:PORT`` for Zenoh, with ``?domain=`` and ``&wait=``.
    environment : mapping of str to str, optional
        Has the domain as ``ROS_DOMAIN_ID`` unless the address has it, as for every program of ROS 2.

    Returns
    -------
    WireAddress
        The address.

    Raises
    ------
    InputError
        If it is not such an address.
    UnknownNameError
        If it has an option of another name.

    Examples
    --------
    >>> parse_address("ros2+zenoh://robot.local?domain=5").domain
    5
    """
    parts, options = _split(text)
    middleware = Middleware(parts.scheme)
    if middleware is Middleware.DDS and parts.port is not None:
        remedy = f"leave out :{parts.port}, or write ros2+zenoh:// for a router of Zenoh"
        raise InputError(text, "DDS computes its ports from the domain", remedy=remedy)
    place = "domain" if "domain" in options else "ROS_DOMAIN_ID"
    named = options.get("domain", environment.get("ROS_DOMAIN_ID", "") or "0")
    nearby = "localhost" if middleware is Middleware.ZENOH else ""
    return WireAddress(
        text=text,
        middleware=middleware,
        host=parts.hostname or nearby,
        port=parts.port or _ZENOH_PORT,
        domain=int(_number(named, text=text, place=place, most=_LAST_DOMAIN)),
        wait=_number(options.get("wait", "10"), text=text, place="wait", most=_LONGEST_WAIT),
    )


def _split(text: str) -> tuple[SplitResult, dict[str, str]]:
    """Split an address into its parts, and its options by their names."""
    try:
        parts = urlsplit(text)
        is_known = is_address(text) and text.startswith(f"{parts.scheme}://") and parts.port != 0
    except ValueError:
        raise InputError(text, "its host or port cannot be", remedy=_EXAMPLE) from None
    if not is_known or parts.path.strip("/") or parts.fragment:
        raise InputError(text, "it is not the address of a ROS 2", remedy=_EXAMPLE)
    options = dict(parse_qsl(parts.query, keep_blank_values=True))
    for option in options:
        if option not in _OPTIONS:
            raise UnknownNameError(f"option of {parts.scheme}://", option, known=_OPTIONS)
    return parts, options


def _number(written: str, *, text: str, place: str, most: float) -> float:
    """Read a whole number of an option."""
    if not re.fullmatch(r"[0-9]{1,6}", written) or int(written) > most:
        problem = f"{written!r} is not a whole number from 0 to {most:g}"
        raise InputError(text, problem, place=place, remedy=f"write for example {place}=5")
    return float(written)

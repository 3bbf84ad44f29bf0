"""Who may see the page and give commands: the same machine, or whoever has the token."""

import hmac
from collections.abc import Mapping
from dataclasses import dataclass
from http import HTTPStatus
from urllib.parse import parse_qs, urlsplit

__all__ = ["LOOPBACK", "SECURITY_HEADERS", "Access"]

LOOPBACK = ("127.0.0.1", "localhost", "::1")

# The page is all in one file, talks to its own server only, and cannot be shown inside another page.
SECURITY_HEADERS: Mapping[str, str] = {
    "Content-Security-Policy": (
        "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; img-src data:; "
        "connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
    ),
    "Cache-Control": "no-store",
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Access:
    """The rule of one server.

    Parameters
    ----------
    token : str, optional
        What the address must contain; without one, the server must be asked for by a name of this machine, so that
        no other name that leads to it (DNS rebinding) is of use.
    """

    token: str = ""

    def refusal(self, *, path: str, host: str, origin: str | None, is_socket: bool) -> HTTPStatus | None:
        """Return the status with which a request is refused; None if it may pass.

        ``path`` has the query, ``host`` and ``origin`` are those of the headers; browsers send the origin with every
        websocket request.
        """
        if self.token:
            given = parse_qs(urlsplit(path).query).get("token", [""])[0]
            if not hmac.compare_digest(given.encode(errors="replace"), self.token.encode()):
                return HTTPStatus.UNAUTHORIZED
        elif _name_of(host) not in LOOPBACK:
            return HTTPStatus.FORBIDDEN
        if is_socket and origin != f"http://{host}":
            return HTTPStatus.FORBIDDEN
        return None


def _name_of(host: str) -> str:
    """Take the port off a Host header."""
    try:
        return urlsplit(f"//{host}").hostname or ""
    except ValueError:
        return ""

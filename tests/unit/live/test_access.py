from http import HTTPStatus

import pytest

from echoplan.live.access import Access

HERE = "127.0.0.1:3246"


def asked(access: Access, path: str = "/", *, host: str = HERE, origin: str | None = None) -> HTTPStatus | None:
    return access.refusal(path=path, host=host, origin=origin, is_socket=path.startswith("/ws"))


@pytest.mark.parametrize("host", [HERE, "localhost:3246", "[::1]:3246"])
def test_this_machine_needs_no_token(host: str) -> None:
    assert asked(Access(), host=host) is None
    assert asked(Access(), "/ws", host=host, origin=f"http://{host}") is None


@pytest.mark.parametrize(
    "host", ["evil.example:3246", "192.168.1.5:3246", "", "127.0.0.1.evil.example", "[", "127.0.0.1@evil"]
)
def test_a_name_that_leads_here_from_elsewhere_is_refused(host: str) -> None:
    assert asked(Access(), host=host) is HTTPStatus.FORBIDDEN
    assert asked(Access(), "/ws", host=host, origin=f"http://{host}") is HTTPStatus.FORBIDDEN


@pytest.mark.parametrize(
    "origin", [None, "", "null", "http://evil.example", "https://127.0.0.1:3246", "http://127.0.0.1:80"]
)
def test_a_websocket_of_another_page_is_refused(origin: str | None) -> None:
    assert asked(Access(), "/ws", origin=origin) is HTTPStatus.FORBIDDEN
    assert asked(Access(token="abc"), "/ws?token=abc", origin=origin) is HTTPStatus.FORBIDDEN


@pytest.mark.parametrize("path", ["/", "/ws", "/saved/map.svg"])
def test_with_a_token_every_request_needs_it(path: str) -> None:
    access = Access(token="right-one")
    origin = "http://10.0.0.2:3246"
    for query in ("", "?token=", "?token=wrong", "?token=right-one%FF", "?Token=right-one", "?token=\udcff"):
        assert asked(access, path + query, host="10.0.0.2:3246", origin=origin) is HTTPStatus.UNAUTHORIZED
    assert asked(access, f"{path}?token=right-one", host="10.0.0.2:3246", origin=origin) is None

"""Ports: the error where one cannot be opened."""

import pytest

from echoplan.errors import InputError
from echoplan.hardware.port import open_port


@pytest.mark.parametrize(
    ("address", "reason"),
    [
        ("serial:///dev/no-such-port", "No such file or directory"),
        ("serial:///", "Is a directory"),
        # No server listens at port 1.
        ("tcp://localhost:1", "Connection refused"),
    ],
)
def test_the_reason_why_a_port_cannot_be_opened_is_named(address: str, reason: str) -> None:
    with pytest.raises(InputError, match=f"^{address}: it cannot be opened: (\\[Errno 111\\] )?{reason}; check"):
        open_port(address)

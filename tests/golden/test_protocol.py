"""The lines that the Arduino sketch, the Python device and the host read alike: tests/golden/protocol/lines.tsv.

``python tests/golden/test_protocol.py`` writes the file anew.
"""

import zlib
from pathlib import Path

import numpy as np
import pytest

from echoplan.hardware.protocol import decode, encode

LINES = Path(__file__).parent / "protocol" / "lines.tsv"

COMMANDS = (
    "hello",
    "config",
    "set,step,100",
    "set,start,-9000",
    "ping,0",
    "ping,65535",
    "sweep,1,1",
    "sweep,65535,0",
    "stop,7",
    "move,8",
    "ack,7,4294967295",
)
REPLIES = (
    "hello,1,0.1.0,uno,4,24,servo-air",
    "hello,1,0.1.0,esp32,8,255,none",
    "value,gain,-1000",
    "pong,7,0,4294967295",
    "accepted,sweep,7",
    "refused,set,range",
    "begin,7,0,1000,0",
    "echo,7,42,1284560,2,1472,-450,8746",
    "echo,7,43,1284585,3,1472,-450,0",
    "echo,65535,4294967295,4294967295,7,2500,9000,-1",
    "air,7,1,1010,2145",
    "air,7,1,1010,-550",
    "wheels,7,2,1020,2147483647,-2147483648",
    "end,7,366,9300000,0",
    "done,7,367,9300010",
)
# Sound checksums about payloads that the protocol does not have.
STRANGE_COMMANDS = (
    "",
    "jump",
    "Hello",
    "hello,1",
    "ping",
    "ping,-1",
    "ping,65536",
    "ping,07",
    "ping,+7",
    "ping, 7",
    "ping,7.0",
    "ping,",
    "ping,9999999999",
    "ping,7,8",
    "sweep,1",
    "set,step",
    "set,,100",
    "set,step,9001",
    "set,st ep,1",
    "ack,7,4294967296",
    "echo,7,42,1284560,2,1472,-450,8746",
    "set," + "s" * 90 + ",1",
)
STRANGE_REPLIES = (
    "echo,7,42,1284560,2,1472,-450",
    "echo,7,42,1284560,2,1472,-450,8746,1",
    "echo,7,42,-1,2,1472,-450,8746",
    "echo,7,42,1284560,8,1472,-450,8746",
    "echo,7,42,1284560,2,1472,-0,8746",
    "echo,7,42,1284560,2,1472,-450,-2",
    "ping,7",
)


def line_of(payload: str) -> str:
    return f"${payload}*{zlib.crc32(payload.encode()):08X}"


def vectors() -> list[tuple[str, str, str]]:
    """Return who sent a line, what it says ("-": nothing) and the line itself."""
    rows = [("host", payload, line_of(payload)) for payload in COMMANDS]
    rows += [("device", payload, line_of(payload)) for payload in REPLIES]
    rows += [("host", "-", line_of(payload)) for payload in STRANGE_COMMANDS]
    rows += [("device", "-", line_of(payload)) for payload in STRANGE_REPLIES]
    ping = line_of("ping,7")
    # Noise around a line and a carriage return do no harm; any damage to it does.
    rows += [("host", "ping,7", text) for text in (f"x?{ping}", f"$pi{ping}", f"{ping}\\r", f"$$${ping}")]
    damaged = (
        ping[1:],
        ping[:-1],
        f"{ping}0",
        ping.lower(),
        ping.replace("*", ","),
        ping.replace("7", "6"),
        f"{ping} ",
        "",
        "$",
        "$*",
    )
    rows += [("host", "-", text) for text in damaged]
    for bit in range(0, 8 * len(ping), 5):
        octets = bytearray(ping.encode())
        octets[bit // 8] ^= 1 << bit % 8
        if bit % 8 < 7 and octets[bit // 8] not in b"\t\n\r\\":
            rows.append(("host", "-", octets.decode()))
    return rows


@pytest.mark.parametrize(("sender", "payload", "line"), vectors())
def test_the_host_reads_and_writes_the_lines_as_devices_do(sender: str, payload: str, line: str) -> None:
    message = decode(line.replace("\\r", "\r").encode("ascii"), is_command=sender == "host")
    if payload == "-":
        assert message is None
    else:
        assert message is not None
        assert encode(message) == f"{line_of(payload)}\n".encode("ascii")


def test_the_file_is_what_its_generator_writes() -> None:
    assert LINES.read_text(encoding="ascii") == written()


def test_the_checksum_detects_up_to_four_wrong_bits_in_the_longest_payload() -> None:
    checksum_of_zeros = zlib.crc32(bytes(80))
    wrong_bits = [zlib.crc32((1 << bit).to_bytes(80)) ^ checksum_of_zeros for bit in range(640)]
    # The checksum itself may have wrong bits, too.
    changes = np.array(wrong_bits + [1 << bit for bit in range(32)], dtype=np.uint32)
    pairs = (changes[:, np.newaxis] ^ changes)[np.triu_indices(len(changes), k=1)]
    # Four wrong bits cancel if two pairs change the checksum alike, three if a pair changes it like a single one.
    assert len(np.unique(np.concatenate([[0], changes, pairs]))) == 1 + len(changes) + len(pairs)


def written() -> str:
    """Return the text of the file."""
    head = "# sender, payload (-: the line must be dropped), line without its line feed (\\r: carriage return)"
    return "\n".join([head, *map("\t".join, vectors()), ""])


if __name__ == "__main__":
    LINES.write_text(written(), encoding="ascii")

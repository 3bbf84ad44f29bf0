"""A bag of ROS 1 or ROS 2: its topics and decoded messages. Errors of its reader become one line."""

import re
import struct
import sys
from collections import Counter
from collections.abc import Collection, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from textwrap import shorten
from typing import TYPE_CHECKING, Any

from echoplan.errors import EchoplanError, InputError, MissingExtraError
from echoplan.io.files import check_file, readable

if TYPE_CHECKING:
    from rosbags.interfaces import Connection
    from rosbags.rosbag1 import Reader as Reader1
    from rosbags.rosbag2 import Reader as Reader2
    from rosbags.typesys.store import Typestore

__all__ = ["Bag", "Message", "Topic", "is_bag", "open_bag", "standard_typestore"]

_SUFFIXES = (".bag", ".mcap", ".db3", ".active", ".zstd", ".zst")
_STORAGES = ("*.mcap", "*.db3")
# The first bytes of a file of each kind, and the suffix by which rosbags recognises it.
_MAGIC = {b"#ROSBAG V": ".bag", b"\x89MCAP0\r\n": ".mcap", b"SQLite format 3\0": ".db3"}
# Problem and remedy by a pattern in the error of the reader; the first match counts.
_PROBLEMS = (
    ("end magic", "it was not closed: its end is missing", "repair it with: mcap recover FILE -o repaired.mcap"),
    ("not indexed", "it was not closed: its index is missing", "repair it with: rosbag reindex FILE"),
    ("index looks damaged", "its index is damaged", "repair it with: rosbag reindex FILE"),
    ("Profile is not ros2", "it is an mcap file without the ROS 2 profile", "convert it to a ROS 2 bag, or record one"),
    ("missing tables", "it is not a bag but another SQLite database", "check the name"),
    ("files are missing", "a file that metadata.yaml names is missing", "copy the whole folder of the bag"),
    ("[Cc]ompression .*not supported|Unsupported chunk", "its compression is not supported", "use: ros2 bag convert"),
    ("ersion .*not supported", "its version is not supported", "use: ros2 bag convert, or pip install -U rosbags"),
    ("Serialization format", "its messages are not CDR", "record it with the default settings of ros2 bag"),
    ("hash mismatch", "its message definitions do not match its messages", "record it again"),
    (
        "^MemoryError$",
        "it is damaged, or a message in it does not fit into memory",
        "record it again, or read it on a computer with more memory",
    ),
)
# Errors of parsers quote whole definitions.
_LONGEST = 100
_DAMAGED = "repair it (ROS 1: rosbag reindex; mcap: mcap recover; sqlite3: ros2 bag reindex), or record it again"


@dataclass(frozen=True, slots=True, kw_only=True)
class Topic:
    """A topic of a bag.

    Parameters
    ----------
    name : str
        Its name.
    type : str
        Type of its messages, as ``sensor_msgs/msg/Range``.
    count : int
        Number of messages.
    """

    name: str
    type: str
    count: int


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Message:
    """A decoded message.

    Parameters
    ----------
    topic : Topic
        Its topic.
    log_ns : int
        When it was recorded [ns].
    body : object
        The message; its fields are attributes.
    """

    topic: Topic
    log_ns: int
    body: Any


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Bag:
    """An open bag.

    Parameters
    ----------
    path : Path
        The file or folder.
    topics : tuple of Topic
        Its topics, by name.
    start_ns, end_ns : int
        Times of the first and of the last message [ns]; equal if there is none.
    is_ros1 : bool
        Whether ROS 1 recorded it.
    reader : Reader
        The reader of rosbags.
    """

    path: Path
    topics: tuple[Topic, ...]
    start_ns: int
    end_ns: int
    is_ros1: bool
    reader: "Reader1 | Reader2"

    def messages(self, topics: Collection[Topic]) -> Iterator[Message]:
        """Yield the messages of some topics in the order in which they were recorded."""
        wanted = {topic.name: topic for topic in topics if topic.count}
        connections = [each for each in self.reader.connections if each.topic in wanted]
        if not connections:
            return
        decoders: dict[str, Typestore] = {}
        with _in_one_line(self.path):
            for connection, log_ns, raw in self.reader.messages(connections):
                store = decoders.get(connection.msgtype)
                if store is None:
                    store = decoders[connection.msgtype] = _typestore(connection, raw, path=self.path)
                decode = store.deserialize_ros1 if self.is_ros1 else store.deserialize_cdr
                yield Message(topic=wanted[connection.topic], log_ns=log_ns, body=decode(raw, connection.msgtype))


def is_bag(path: Path) -> bool:
    """Return whether a path is a bag: by the first bytes or the suffix of a file, or by the content of a folder.

    Parameters
    ----------
    path : Path
        The file or folder; it need not exist.

    Returns
    -------
    bool
        True for whatever should be read as a bag, even if reading it fails.
    """
    with readable(path):
        if not path.is_dir():
            return path.suffix.lower() in _SUFFIXES or bool(path.is_file() and _kind_of(path))
        if (path / "pings.csv").exists():
            return False
        return (path / "metadata.yaml").exists() or any(True for form in _STORAGES for _ in path.glob(form))


@contextmanager
def open_bag(path: Path) -> Iterator[Bag]:
    """Open a bag: a file of ROS 1 (.bag) or ROS 2 (.mcap, .db3), or the folder of a ROS 2 bag.

    Parameters
    ----------
    path : Path
        The bag.

    Yields
    ------
    Bag
        What is in it.

    Raises
    ------
    InputError
        If it is not a bag or cannot be read, when it is opened or while its messages are read.
    MissingExtraError
        If rosbags is not installed.
    """
    try:
        from rosbags.rosbag1 import Reader as Reader1  # noqa: PLC0415 - rosbags is optional
        from rosbags.rosbag2 import Reader as Reader2  # noqa: PLC0415
    except ModuleNotFoundError as error:
        raise MissingExtraError("rosbags", extra="ros") from error

    storage = _storage_of(path)
    is_ros1 = storage.is_file() and _kind_of(storage) == ".bag"
    with _in_one_line(path):
        reader = (Reader1 if is_ros1 else Reader2)(storage)
        reader.open()
    try:
        counts: Counter[tuple[str, str]] = Counter()
        for each in reader.connections:
            counts[each.topic, each.msgtype] += each.msgcount
        topics = tuple(Topic(name=name, type=kind, count=count) for (name, kind), count in sorted(counts.items()))
        start, end = (reader.start_time, reader.end_time) if sum(counts.values()) else (0, 0)
        yield Bag(path=path, topics=topics, start_ns=start, end_ns=end, is_ros1=is_ros1, reader=reader)
    finally:
        with _in_one_line(path):
            reader.close()


def _storage_of(path: Path) -> Path:
    """Find the path that the reader opens, and refuse files that it cannot read."""
    check_file(path)
    with readable(path):
        if not path.is_dir():
            _check_kind(path)
            return path
        if (path / "metadata.yaml").exists():
            return path
        found = sorted(each for form in _STORAGES for each in path.glob(form))
    if len(found) > 1:
        raise InputError(path, "metadata.yaml is missing", remedy="restore it with: ros2 bag reindex FOLDER")
    return _storage_of(found[0])


def _kind_of(path: Path) -> str:
    """Return the suffix that matches the first bytes of a file; empty if it is not a bag."""
    with path.open("rb") as file:
        start = file.read(max(map(len, _MAGIC)))
    return next((suffix for magic, suffix in _MAGIC.items() if start.startswith(magic)), "")


def _check_kind(path: Path) -> None:
    """Refuse a file that is not a bag, was not closed, is compressed, or has the suffix of another kind."""
    kind = _kind_of(path)
    if path.suffix == ".active":
        remedy = "close it with: rosbag reindex FILE, and name it without .active"
        raise InputError(path, "it was not closed", remedy=remedy)
    if path.suffix in (".zstd", ".zst"):
        raise InputError(path, "the file is compressed", remedy="name its folder, or decompress it: zstd -d FILE")
    if not path.stat().st_size:
        raise InputError(path, "the file is empty", remedy="record it again")
    if not kind:
        raise InputError(path, "it is not a bag, although its name ends like one", remedy="check the name")
    # rosbags distinguishes the kinds of ROS 2 bags by their suffixes.
    if path.suffix != kind != ".bag":
        raise InputError(path, f"it is a {kind} file by its first bytes", remedy=f"name it {path.stem}{kind}")


def _typestore(connection: "Connection", raw: bytes, *, path: Path) -> "Typestore":
    """Register a message type from its definition in the bag, or else from the distributions of ROS."""
    from rosbags.interfaces import MessageDefinitionFormat  # noqa: PLC0415 - rosbags is optional
    from rosbags.typesys import Stores, get_types_from_idl, get_types_from_msg, get_typestore  # noqa: PLC0415

    kind, definition = connection.msgtype, connection.msgdef
    if definition.format == MessageDefinitionFormat.NONE:
        # Bags before ROS 2 Iron hold no definitions.
        known = standard_typestore(kind, raw)
        if known is None:
            problem = f"messages of type {kind} on {connection.topic} are not defined in the bag"
            raise InputError(path, problem, remedy="record it with ROS 2 Iron or newer, or as mcap")
        return known
    store = get_typestore(Stores.EMPTY)
    if definition.format == MessageDefinitionFormat.IDL:
        for part in definition.data.split("=" * 80 + "\n"):
            store.register(get_types_from_idl(part.split("\n", 1)[-1] if part.startswith("IDL: ") else part))
    else:
        store.register(get_types_from_msg(definition.data, kind))
    return store


def standard_typestore(kind: str, raw: bytes) -> "Typestore | None":
    """Find the distribution of ROS 2 that wrote a message of a standard type; None if the type is not standard."""
    from rosbags.serde import SerdeError  # noqa: PLC0415 - rosbags is optional
    from rosbags.typesys import Stores, get_typestore  # noqa: PLC0415

    # Iron is where Range got its variance.
    for distribution in (Stores.LATEST, Stores.ROS2_HUMBLE):
        store = get_typestore(distribution)
        if kind not in store.fielddefs:
            return None
        try:
            store.deserialize_cdr(raw, kind)
        except (SerdeError, IndexError):
            continue
        break
    return store


@contextmanager
def _in_one_line(path: Path) -> Iterator[None]:
    """Turn whatever rosbags and its decoders raise about damaged files into an ``InputError``."""
    import apsw  # noqa: PLC0415 - rosbags and what comes with it are optional
    from rosbags import rosbag1, rosbag2, serde, typesys  # noqa: PLC0415

    if sys.version_info >= (3, 14):
        from compression import zstd  # noqa: PLC0415
    else:
        from backports import zstd  # noqa: PLC0415

    try:
        yield
    except EchoplanError:
        raise
    except (
        *(rosbag1.ReaderError, rosbag2.ReaderError, serde.SerdeError, typesys.TypesysError),
        *(apsw.Error, zstd.ZstdError, struct.error, EOFError, OSError, MemoryError),
        # Damaged files cause assertion, index and attribute errors; lz4 raises RuntimeError.
        *(ValueError, LookupError, TypeError, AttributeError, AssertionError, ArithmeticError, RuntimeError),
    ) as error:
        said = str(error).replace(str(path), path.name) or type(error).__name__
        for sign, problem, remedy in _PROBLEMS:
            if re.search(sign, said):
                raise InputError(path, problem, remedy=remedy.replace("FILE", path.name)) from error
        problem = f"it is damaged or cut short ({shorten(said, _LONGEST, placeholder=' ...')})"
        raise InputError(path, problem, remedy=_DAMAGED) from error

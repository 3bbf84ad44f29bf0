"""Types of DDS for messages of ROS 2: they carry CDR as it is, and describe it to peers that compare types."""

from typing import TYPE_CHECKING, Any

from echoplan.io.ros.wire.transport import type_on_wire

if TYPE_CHECKING:
    from rosbags.interfaces import Nodetype
    from rosbags.typesys.store import Typestore

__all__ = ["wire_type"]


def wire_type(kind: str, store: "Typestore | None") -> Any:
    """Make the type of a topic: with the fields of its messages, or opaque without a store of definitions.

    Its instances have the CDR as ``data``. An opaque type receives the messages of every distribution, from peers that
    compare types by their names alone.
    """
    from cyclonedds.idl import make_idl_struct  # noqa: PLC0415 - an extra

    def with_data(self: Any, data: bytes) -> None:
        """Hold a message as CDR."""
        self.data = data

    def serialized(self: Any, **_: object) -> bytes:
        """Return the CDR to send."""
        data: bytes = self.data
        return data

    def deserialized(cls: Any, data: bytes, /, **_: object) -> Any:
        """Hold the CDR that was received."""
        return cls(bytes(data))

    fields = {} if store is None else _fields(kind, store, made={})
    made = make_idl_struct(kind.replace("/", "_"), type_on_wire(kind), fields, dataclassify=False)
    made.__init__, made.serialize = with_data, serialized
    made.deserialize = made.deserialize_key = classmethod(deserialized)
    return made


def _fields(kind: str, store: "Typestore", *, made: dict[str, Any]) -> dict[str, Any]:
    """Return the types of the fields of a message; structures inside are made once."""
    return {name: _type_of(described, store, made=made) for name, described in store.fielddefs[kind][1]}


def _type_of(described: "tuple[Nodetype, Any]", store: "Typestore", *, made: dict[str, Any]) -> Any:
    """Return the type of a field, as the IDL of Cyclone DDS has it."""
    from cyclonedds.idl import make_idl_struct, types  # noqa: PLC0415 - an extra
    from rosbags.interfaces import Nodetype  # noqa: PLC0415 - an extra

    node, content = described
    if node == Nodetype.NAME:
        if content not in made:
            fields = _fields(content, store, made=made)
            made[content] = make_idl_struct(content.replace("/", "_"), type_on_wire(content), fields)
        return made[content]
    if node == Nodetype.BASE:
        name, most = content
        if name == "string" and most:
            return types.bounded_str[most]
        return {"bool": bool, "octet": types.byte, "string": str}.get(name) or getattr(types, name)
    inside, count = content
    element = _type_of(inside, store, made=made)
    if node == Nodetype.ARRAY:
        return types.array[element, count]
    return types.sequence[(element, count)[: 1 + bool(count)]]

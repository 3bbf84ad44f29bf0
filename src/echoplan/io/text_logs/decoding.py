"""Bytes to lines: the encoding of a text log, and line ends of any system."""

import codecs
import re
from pathlib import Path

from echoplan.errors import InputError
from echoplan.io.files import check_file, readable

__all__ = ["decode", "read_lines"]

# A log of a week at ten readings a second is smaller; what is larger is no log [bytes].
_LARGEST = 200_000_000
# Control characters are noise of a serial line; where they are more than one in ten, the file is no text.
_MOST_CONTROLS = 0.1
# Share of bytes below 128 in a log of numbers with a few signs of an 8-bit character set.
_ASCII = 0.8
# UTF-32 first: the mark of UTF-16 begins that of UTF-32.
_MARKS = {
    codecs.BOM_UTF8: "utf-8-sig",
    codecs.BOM_UTF32_LE: "utf-32",
    codecs.BOM_UTF32_BE: "utf-32",
    codecs.BOM_UTF16_LE: "utf-16",
    codecs.BOM_UTF16_BE: "utf-16",
}


def read_lines(path: Path) -> tuple[list[str], str]:
    """Return the lines of a text file, and its encoding."""
    check_file(path)
    with readable(path):
        if path.stat().st_size > _LARGEST:
            raise InputError(path, f"it is larger than {_LARGEST // 1_000_000} MB", remedy="cut it into several logs")
        data = path.read_bytes()
    text, encoding = decode(data, path)
    # Some monitors end lines by CR CR LF. A form feed or a line separator within a line is noise, not an end.
    lines = re.split(r"\r\r?\n|\n|\r", text)
    return lines, encoding


def decode(data: bytes, path: Path) -> tuple[str, str]:
    """Return the text that bytes stand for, and their encoding."""
    encoding = next((name for mark, name in _MARKS.items() if data.startswith(mark)), "utf-8")
    try:
        text = data.decode(encoding)
    except UnicodeDecodeError:
        # A degree sign among digits is no sample of a language: one of an old Windows or Linux is as good as any.
        is_ascii = len(data.translate(None, bytes(range(128)))) < (1.0 - _ASCII) * len(data)
        text, encoding = (data.decode("latin-1"), "latin-1") if is_ascii else ("\0", "")
    # In UTF-16 without a mark every second byte of English text is zero; noise on a serial line is not so regular.
    if text.count("\0") > len(text) / 4:
        from charset_normalizer import from_bytes  # noqa: PLC0415 - takes a tenth of a second, for odd files only

        best = from_bytes(data).best()
        if best is None:
            raise InputError(path, "it is no text in any known encoding", remedy="save it as UTF-8")
        text, encoding = str(best), best.encoding
    if len(re.findall(r"[\0-\x08\x0e-\x1f\x7f]", text)) > _MOST_CONTROLS * len(text):
        raise InputError(path, "it is no text", remedy="name the text that the serial monitor showed, or a recording")
    return text, encoding.removesuffix("-sig")

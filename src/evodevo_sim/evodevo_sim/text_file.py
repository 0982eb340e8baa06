"""Files that people write, of every kind: YAML or JSON read within limits of size, number of values and depth.

Numbers are spelt as in YAML 1.2, in decimal digits: 1e-5 is one.  Words stay words (yes, on, 2024-02-28); only true, false and null
are not text.  Spellings that are numbers or dates to other readers of YAML, and cannot be told apart or cannot be (1:30, 0x_, 017, 1_000,
2024-02-30), are refused with their line; quotes make them text.  Anchors, aliases, tags and directives are refused, and so is a
key that comes twice.
"""

from __future__ import annotations

import codecs
import json
import os
import re
import stat
from collections.abc import Sequence
from datetime import datetime, timedelta, timezone
from typing import Any

import yaml
from yaml.events import (
    AliasEvent,
    DocumentStartEvent,
    MappingEndEvent,
    MappingStartEvent,
    ScalarEvent,
    SequenceEndEvent,
    SequenceStartEvent,
)

from .inputs import LONGEST_NUMBER, InputError, decimal, nearest, shown

MOST_BYTES = 16_000_000  # a genome of 100,000 elements has up to 10,000,000, a world of two profiles of 100,000 points 12,000,000
MOST_VALUES = 1_000_000  # that genome has 900,000 keys and values
MOST_DEPTH = 16  # lists and mappings within each other; no kind of file has more than 3
_TOO_MANY = f"has more than {MOST_VALUES:,} values, the most that is read: give fewer"
_Events = getattr(yaml, "CSafeLoader", yaml.SafeLoader)  # only its events are used: the C composer calls itself without a limit
_CONSTANTS = {"": None, "~": None} | {
    form(word): value for word, value in (("null", None), ("true", True), ("false", False)) for form in (str, str.capitalize, str.upper)
}
_NOT_FINITE = {sign + form: float(sign + "inf") for sign in ("", "+", "-") for form in (".inf", ".Inf", ".INF")}
_NOT_FINITE |= dict.fromkeys((".nan", ".NaN", ".NAN"), float("nan"))
_NUMERIC = frozenset("+-.0123456789")  # how numbers and dates begin
_AMBIGUOUS = re.compile(r"[-+]?(0b[01_]*|0o[0-7_]*|0x[0-9a-fA-F_]*|\.?[0-9][0-9_]*(:[0-5]?[0-9])*(\.[0-9_]*)?([eE][-+]?[0-9]+)?)")
_DATE = re.compile(
    r"(\d{4})-(\d\d?)-(\d\d?)(?:(?:[Tt]|[ \t]+)(\d\d?):(\d\d):(\d\d)(?:\.\d*)?(?:[ \t]*(?:Z|([-+]\d\d?)(?::?(\d\d))?))?)?", re.ASCII
)
_BYTE_ORDERS = {
    codecs.BOM_UTF32_LE: "UTF-32", codecs.BOM_UTF32_BE: "UTF-32", codecs.BOM_UTF16_LE: "UTF-16", codecs.BOM_UTF16_BE: "UTF-16",
}


def read_text(path: str | os.PathLike, error: type[InputError], give: str) -> str:
    """The text of a regular file of UTF-8 that is not empty.

    Args: error: what is raised, with the file, what is wrong and the mend; give: the mend, e.g. "the path of a genome file".
    """
    try:
        handle = os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC)  # the opening of a pipe does not wait
        with open(handle, "rb") as file:
            kind = os.fstat(handle).st_mode
            data = file.read(MOST_BYTES + 1) if stat.S_ISREG(kind) else b""
    except (OSError, ValueError) as fault:  # ValueError: a NUL in the name
        raise error(f"{path}: {getattr(fault, 'strerror', None) or fault}: give {give}") from None
    if not stat.S_ISREG(kind):
        raise error(f"{path} is {'a directory' if stat.S_ISDIR(kind) else 'a pipe or a device'}: give {give}")
    if len(data) > MOST_BYTES:
        raise error(f"{path} has more than {MOST_BYTES:,} bytes, the most that is read: give {give}")
    return _decoded(data, path, error, give)


def _decoded(data, path, error, give):
    for mark, name in _BYTE_ORDERS.items():
        if data.startswith(mark):
            raise error(f"{path} is {name}: save it as UTF-8")
    data = data.removeprefix(codecs.BOM_UTF8)
    wrong, what = data.find(b"\0"), "a NUL byte"
    try:
        text = data.decode("utf-8")
    except UnicodeDecodeError as fault:
        if not 0 <= wrong < fault.start:
            wrong, what = fault.start, "bytes that are no UTF-8"
    if wrong >= 0:
        line = data.count(b"\n", 0, wrong) + 1
        raise error(f"{path} is not a text file, line {line} has {what}: give {give}")
    if not text.strip():
        raise error(f"{path} is empty: give {give}")
    return text


def parsed(text: str, error: type[InputError]) -> Any:
    """What a text of YAML or JSON says: dicts with keys of text, lists, text, numbers, booleans and None.

    Args: error: what is raised, with the line or key, and the mend.
    """
    if text.lstrip()[:1] in ("{", "["):
        if text.count(",") >= MOST_VALUES:
            raise error(_TOO_MANY)
        try:
            return json.loads(text, object_pairs_hook=lambda pairs: _without_doubles(pairs, error), parse_int=_whole)
        except error:
            raise
        except (ValueError, RecursionError):  # YAML has lists and mappings in such brackets too
            pass
    directive = re.search("^%", text, re.MULTILINE)
    if directive:
        line = text.count("\n", 0, directive.start()) + 1
        raise error(f"line {line}: begins with %, a directive of YAML: delete the line, or quote the text")
    try:
        events = _Events(text)
        try:
            return _built(events, error)
        finally:
            events.dispose()
    except yaml.MarkedYAMLError as fault:
        mark = fault.problem_mark or fault.context_mark
        where = f" from line {mark.line + 1} on" if mark else ""
        raise error(f"neither YAML nor JSON{where} ({fault.problem}): mend its syntax") from None
    except (yaml.YAMLError, UnicodeEncodeError) as fault:  # characters that cannot be printed
        position = fault.start if isinstance(fault, UnicodeEncodeError) else getattr(fault, "position", 0)
        line = text.count("\n", 0, position) + 1
        raise error(f"line {line}: {shown(text[position : position + 1])} is no character of YAML: delete it") from None


def _without_doubles(pairs, error):
    found: dict[str, object] = {}
    for key, value in pairs:
        if key in found:
            raise error(f"the key {shown(key)} comes twice: keep one of them")
        found[key] = value
    return found


def _whole(text):
    number = decimal(text)
    return float(text) if number is None else number


def _built(events, error):
    """The document of events of YAML.  Nothing here calls itself, however deep the document is."""
    outer: list = []  # what the open lists and mappings stand in, and the key that waited there
    inside, key, document, began, values = None, None, None, False, 0
    while events.check_event():
        event = events.get_event()
        kind = type(event)
        if kind in (SequenceEndEvent, MappingEndEvent):
            inside, key = outer.pop()
            continue
        if kind is DocumentStartEvent and began:
            raise error(f"line {_line(event)}: a second document begins: keep one")
        if kind not in (ScalarEvent, SequenceStartEvent, MappingStartEvent, AliasEvent):
            continue
        if kind is AliasEvent or event.anchor is not None:
            raise error(f"line {_line(event)}: {shown(event.anchor)} is an alias or an anchor: write out what it stands for")
        if event.tag is not None:
            raise error(f"line {_line(event)}: {shown(event.tag)} is a tag of YAML: leave it out")
        values, began = values + 1, True
        if values > MOST_VALUES:
            raise error(_TOO_MANY)
        if type(inside) is dict and key is None:
            if kind is not ScalarEvent:
                raise error(f"line {_line(event)}: a key is a list or a mapping: give a word")
            key = event.value
            if key in inside:
                raise error(f"line {_line(event)}: the key {shown(key)} comes twice: keep one of them")
            continue
        if kind is ScalarEvent:
            value = _scalar(event, error) if event.implicit[0] else event.value
        else:
            value = [] if kind is SequenceStartEvent else {}
        if type(inside) is dict:
            inside[key] = value
        elif inside is not None:
            inside.append(value)
        else:
            document = value
        if kind is ScalarEvent:
            key = None
            continue
        if len(outer) == MOST_DEPTH:
            raise error(f"line {_line(event)}: more than {MOST_DEPTH} lists or mappings within each other: take brackets away")
        outer.append((inside, None))
        inside, key = value, None
    return document


def _line(event):
    return event.start_mark.line + 1


def _scalar(event, error):
    """The value of a scalar without quotes."""
    text = event.value
    if text[:1] not in _NUMERIC or len(text) > LONGEST_NUMBER:
        return _CONSTANTS.get(text, text)
    number = decimal(text)
    if number is not None:
        return number
    if text in _NOT_FINITE:
        return _NOT_FINITE[text]
    if _AMBIGUOUS.fullmatch(text):
        what = "is a number to some readers of YAML only"
        raise error(f"line {_line(event)}: {shown(text)} {what}: give a decimal number, or quotes if it is text")
    if not _can_be(_DATE.fullmatch(text)):
        raise error(f"line {_line(event)}: {shown(text)} is no date or time: mend it, or give quotes if it is text")
    return text


def _can_be(date):
    """Whether a match of _DATE is a day and time that there is; no match can be anything."""
    if date is None:
        return True
    year, month, day, hour, minute, second, hours, minutes = (int(part or 0) for part in date.groups())
    try:
        datetime(year, month, day, hour, minute, second, tzinfo=timezone(timedelta(hours=hours, minutes=minutes)))
    except ValueError:
        return False
    return True


def check_keys(error: type[InputError], document: Any, known: Sequence[str], where: str) -> None:
    """Raise `error` where a section is no mapping, or has a key that is not known.  Args: where: the section; empty: the file."""
    if not isinstance(document, dict):
        raise error(f"{where or 'the file'} is {shown(document)}: give the keys {', '.join(known)}")
    for key in document:
        if key not in known:
            raise error(f"unknown key {shown(f'{where}.{key}' if where else str(key))}: did you mean {nearest(key, known)!r}?")

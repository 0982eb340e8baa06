"""Messages of an SQLite file as rosbag2 writes it (storage `sqlite3`), of every version of its tables."""

from __future__ import annotations

import sqlite3
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from urllib.parse import quote

from .definitions import HOW, RecordingError
from .stored import Channel, Damage, Stored

_DAMAGE = (sqlite3.Error, ValueError, OverflowError)  # that damage can set off; sqlite3 decodes its own messages


def sqlite_messages(path: Path, damage: Damage) -> Iterator[Stored]:
    """The messages in the order in which they were written.  Raises RecordingError where it is no such file."""
    with closing(_opened(path)) as database:
        channels = _channels(path, database)
        rows = database.execute("SELECT topic_id, timestamp, data FROM messages ORDER BY id")
        while True:
            try:
                row = rows.fetchone()
            except _DAMAGE:
                damage.cut = f"{path} is damaged"
                return
            if row is None:
                return
            number, time, data = row
            if number in channels and isinstance(time, int) and isinstance(data, bytes):
                yield Stored(channels[number], time, data)


def _opened(path: Path) -> sqlite3.Connection:
    """The database, for reading alone; without its log where the directory cannot be written."""
    for how in ("mode=ro", "mode=ro&immutable=1"):
        try:
            database = sqlite3.connect(f"file:{quote(str(path.resolve()))}?{how}", uri=True)
            database.text_factory = lambda text: text.decode(errors="replace")
            database.execute("SELECT count(*) FROM sqlite_master").fetchone()
            return database
        except _DAMAGE:
            continue
    raise RecordingError(f"{path} is not an SQLite file: {HOW}")


def _channels(path: Path, database: sqlite3.Connection) -> dict[int, Channel]:
    try:
        columns = {row[1] for row in database.execute("PRAGMA table_info(topics)")}
        given = "type_description_hash" if "type_description_hash" in columns else "''"
        topics = database.execute(f"SELECT id, name, type, serialization_format, {given} FROM topics").fetchall()
        texts = {}
        if database.execute("PRAGMA table_info(message_definitions)").fetchall():
            rows = database.execute("SELECT topic_type, encoding, encoded_message_definition FROM message_definitions")
            texts = {name: (encoding, text) for name, encoding, text in rows}
    except _DAMAGE:
        raise RecordingError(f"{path} is an SQLite file, but no recording of rosbag2: {HOW}") from None
    found = {}
    for number, name, kind, encoding, type_hash in topics:
        language, text = texts.get(kind, ("", ""))
        name, kind, encoding, language, text, type_hash = map(_text, (name, kind, encoding, language, text, type_hash))
        found[number] = Channel(name, kind, encoding, language, text.encode(), type_hash)
    return found


def _text(value) -> str:
    return value if isinstance(value, str) else ""

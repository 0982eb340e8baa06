"""Names of compressions, by the bytes with which compressed data begins."""

from __future__ import annotations

_BEGINS = {b"\x28\xb5\x2f\xfd": "zstd", b"\x04\x22\x4d\x18": "lz4", b"\x1f\x8b": "gzip", b"BZh": "bzip2", b"\xfd7zXZ": "xz"}


def compression_of(data: bytes) -> str:
    """The compression of some data, or nothing."""
    return next((name for begin, name in _BEGINS.items() if data[: len(begin)] == begin), "")

"""What people give as text: how numbers are spelt, how messages show values, and the base of the errors about them."""

from __future__ import annotations

import difflib
import re
import reprlib
from collections.abc import Iterable

MOST_CHARACTERS = 270  # of an error's message; a command adds its name and a hint, and stays within 300
_DECIMAL = re.compile(r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?")
_WHOLE = re.compile(r"[-+]?(0|[1-9][0-9]*)")
_LONGEST_WHOLE = 20  # characters of a whole number that is read as one; what is longer is a float
LONGEST_NUMBER = 1000  # characters


class InputError(Exception):
    """What somebody gave cannot be used.  The message is one line, cut in its middle where it would be too long."""

    def __init__(self, message: object = ""):
        super().__init__(one_line(str(message)))


def one_line(text: str, most: int = MOST_CHARACTERS) -> str:
    """A text with every character printable and on one line, cut in the middle to at most `most` characters."""
    text = _cut(text, 4 * most)
    if not text.isprintable():
        text = "".join(c if c.isprintable() else repr(c)[1:-1] for c in text)
    return _cut(text, most)


def shown(value: object, most: int = 60) -> str:
    """A value as a message shows it: its repr, of large values a part, in at most `most` characters."""
    how = reprlib.Repr()
    how.maxlevel, how.maxlist, how.maxtuple, how.maxdict, how.maxset = 3, 4, 4, 4, 4
    how.maxstring = how.maxlong = how.maxother = most
    try:
        return one_line(how.repr(value), most)
    except (ValueError, RecursionError):  # Python does not write whole numbers of more than 4300 digits
        return f"a huge {type(value).__name__}"


def _cut(text, most):
    if len(text) <= most:
        return text
    end = (most - 5) // 2
    return f"{text[: most - 5 - end]} ... {text[len(text) - end :]}"


def decimal(text: str) -> int | float | None:
    """The number that a text spells in decimal digits, e.g. -3, .5 or 1e-5; None where it spells none.

    Other spellings are read in different ways by different programs: 0x1F, 1_000, 017, 1:30, digits other than 0 to 9.
    Infinity comes of an exponent, or of whole numbers, that no float holds.
    """
    if len(text) <= _LONGEST_WHOLE and _WHOLE.fullmatch(text):
        return int(text)
    if len(text) > LONGEST_NUMBER or not _DECIMAL.fullmatch(text) or (text.lstrip("+-").isdigit() and not _WHOLE.fullmatch(text)):
        return None
    return float(text)


def nearest(word: object, known: Iterable[str]) -> str:
    """The one of `known` that is spelt most like `word`."""
    return difflib.get_close_matches(str(word)[:100], known, 1, 0.0)[0]

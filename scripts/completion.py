"""Writes what shells complete after `ros2 run`, from the commands' own parsers: src/PACKAGE/completion/PACKAGE.sh.

    python scripts/completion.py

Each file holds one function, for bash and zsh alike, that prints the words that fit: of a package its commands, of a command its
options, of an option its choices, or <files> or <any>.  `evodevo.bash` and `evodevo.zsh` ask it; scripts/env.sh sources all.
"""

from __future__ import annotations

import argparse
import importlib
import re
import sys
from pathlib import Path
from unittest import mock

ROOT = Path(__file__).resolve().parents[1]
PACKAGES = ("evodevo_sim", "evodevo_ga")
FILES = re.compile(r"BAG|DIR|FILE|GENOME|BODY|RUN|RECORDING|WORLD|PATH")  # in what stands for a value


class _Found(Exception):
    pass


def commands(package: str) -> dict[str, str]:
    """Module and function of each command of a package, as its setup.py has them."""
    return dict(re.findall(r'"(\w+) = ([\w.]+:\w+)"', (ROOT / "src" / package / "setup.py").read_text(encoding="utf-8")))


def parser_of(entry: str) -> argparse.ArgumentParser:
    """The parser of a command.  Args: entry: module:function of its entry point."""
    module, _, function = entry.partition(":")
    found: list[argparse.ArgumentParser] = []

    def keep(parser, *_, **__):
        found.append(parser)
        raise _Found

    with mock.patch.object(argparse.ArgumentParser, "parse_args", keep):
        try:
            getattr(importlib.import_module(module), function).__wrapped__()([])
        except _Found:
            return found[0]
    raise RuntimeError(f"{entry} has no parser of argparse")


def words_of(parser: argparse.ArgumentParser) -> dict[str, str]:
    """What can stand: at "" the options, at "-" what no option is before, at each option that takes a value its choices."""
    found = {"": " ".join(sorted(name for action in parser._actions for name in action.option_strings if name != "-h"))}
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            found.setdefault("-", " ".join(action.choices))
        elif not action.option_strings:
            found.setdefault("-", _values(action))  # choices of the first one; files come beside them
        elif action.nargs != 0:
            found |= dict.fromkeys(action.option_strings, _values(action))
    return found


def _values(action: argparse.Action) -> str:
    if action.choices:
        return " ".join(map(str, action.choices))
    stands = action.metavar if isinstance(action.metavar, str) else action.dest
    listed = re.match(r"(?:.*: )?((?:[a-z][\w-]*, )+[a-z][\w-]*)(?:,? or | \(|$)", action.help or "")
    files = " <files>" if FILES.search(stands) else ""
    if listed and "NAME" in stands:
        return listed[1].replace(",", "") + files
    return files.strip() or "<any>"


def text(package: str) -> str:
    """The file of a package."""
    lines = [
        f"# What can stand after `ros2 run {package}`; made by scripts/completion.py.", f"_evodevo_words_{package}() {{",
        '    case "$1 $2" in',
    ]
    entries = commands(package)
    lines.append(f'        " ") echo "{" ".join(sorted(entries))}" ;;')
    for name in sorted(entries):
        for option, words in sorted(words_of(parser_of(entries[name])).items()):
            lines.append(f'        "{name} {option}") echo "{words}" ;;')
    return "\n".join([*lines, "    esac", "}"]) + "\n"


def file_of(package: str) -> Path:
    return ROOT / "src" / package / "completion" / f"{package}.sh"


if __name__ == "__main__":
    for one in PACKAGES:
        file_of(one).parent.mkdir(exist_ok=True)
        file_of(one).write_text(text(one), encoding="utf-8")
    sys.exit(0)

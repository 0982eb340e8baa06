"""What the command lines share: an error is one line with the mend, and exit code 2."""

from __future__ import annotations

import argparse


class Parser(argparse.ArgumentParser):
    """A parser whose description and epilog keep their lines."""

    def __init__(self, prog: str, description: str, epilog: str):
        super().__init__(prog=prog, description=description, epilog=epilog, formatter_class=argparse.RawDescriptionHelpFormatter)

    def error(self, message):
        self.exit(2, f"{self.prog}: {message} (see --help)\n")

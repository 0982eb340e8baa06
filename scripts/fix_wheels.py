"""Point the CMake files of the ROS wheels at this interpreter's headers.

The wheels carry the header directories of the machine that built them.  Run with the environment's own Python; a second
run changes nothing.
"""

import re
import sys
import sysconfig
from pathlib import Path

import numpy

BUILD_MACHINE = r"/opt/python/cp\d+-cp\d+/"
REPLACEMENTS = [
    (re.compile(BUILD_MACHINE + r"lib/python3\.\d+/site-packages/numpy/_core/include"), numpy.get_include()),
    (re.compile(BUILD_MACHINE + r"include/python3\.\d+"), sysconfig.get_path("include")),
]


def main() -> None:
    changed = 0
    for path in Path(sys.prefix).glob("share/*/cmake/*.cmake"):
        text = fixed = path.read_text(encoding="utf-8")
        for pattern, directory in REPLACEMENTS:
            fixed = pattern.sub(lambda _, directory=directory: directory, fixed)
        if fixed != text:
            path.write_text(fixed, encoding="utf-8")
            changed += 1
    print(f"header directories rewritten in {changed} CMake files")


if __name__ == "__main__":
    main()

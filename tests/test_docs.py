"""The pages hold what they say: links, paths, commands, flags, parameters, messages, and Python that compiles."""

import importlib.util
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
DOCS = ROOT / "docs"
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted(DOCS.rglob("*.md"))]
SIM, GA = ROOT / "src/evodevo_sim/evodevo_sim", ROOT / "src/evodevo_ga/evodevo_ga"
OURS = ("src/", "docs/", "tests/", "benchmarks/", "scripts/", "examples/", "bags/sample-", "launch/")
TEXT = {page: page.read_text(encoding="utf-8") for page in PAGES}
NAMES = [str(page.relative_to(ROOT)) for page in PAGES]


def page_text(name):
    return TEXT[ROOT / name]


def fences(text):
    """(language, code) of every block between fences."""
    return re.findall(r"^```(\w*)\n(.*?)^```", text, re.DOTALL | re.MULTILINE)


def without_fences(text):
    return re.sub(r"^```\w*\n.*?^```", "", text, flags=re.DOTALL | re.MULTILINE)


def anchors(text):
    """Anchors of headings, as GitHub makes them."""
    found = re.findall(r"^#+ (.*)$", without_fences(text), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-") for title in found}


def wrong_links(page, text):
    wrong = []
    for target in re.findall(r"\]\(([^)\s]+)\)", without_fences(text)):
        if re.match(r"\w+:", target):
            continue
        path, _, anchor = target.partition("#")
        place = (page.parent / path).resolve() if path else page
        if not place.exists() or (anchor and anchor not in anchors(place.read_text(encoding="utf-8"))):
            wrong.append(target)
    return wrong


def wrong_paths(text):
    """Paths in backticks that look like ours and are not there."""
    wrong = []
    for name in re.findall(r"`([\w./-]+)`", without_fences(text)):
        if name.startswith(OURS) or (name.endswith(".py") and not name.startswith("/")):
            places = (ROOT, SIM, GA)
        elif re.fullmatch(r"\w+/(?:[\w/]+)?", name) and (SIM / name.split("/")[0]).is_dir():
            places = (SIM,)
        else:
            continue
        if name != "benchmarks/results" and not any((place / name).exists() for place in places):
            wrong.append(name)
    return wrong


@pytest.mark.parametrize("name", NAMES)
def test_links_paths_and_python_of_a_page_hold(name):
    text = page_text(name)
    assert wrong_links(ROOT / name, text) == []
    assert wrong_paths(text) == []
    for language, code in fences(text):
        if language == "python":
            compile(code, name, "exec")


def test_what_is_wrong_is_seen():
    page = DOCS / "README.md"
    links = "[a](nowhere.md) [b](glossary.md#nothing) [c](glossary.md#genome-and-network)"
    assert wrong_links(page, links) == ["nowhere.md", "glossary.md#nothing"]
    paths = "`physics/nothing.py` `physics/forces.py` `tests/none.py` `settings.py` `nodes/`"
    assert wrong_paths(paths) == ["physics/nothing.py", "tests/none.py"]
    assert wrong_flags("ros2 run evodevo_sim gait BAG --walk --fly", {"gait": "--walk"}) == ["gait --fly"]


def test_every_page_is_reached_from_the_readme():
    seen, ahead = set(), [ROOT / "README.md"]
    while ahead:
        page = ahead.pop()
        if page not in seen and page in TEXT:
            seen.add(page)
            ahead += [(page.parent / link.partition("#")[0]).resolve() for link in re.findall(r"\]\(([^)\s:]+)\)", TEXT[page])]
    assert seen == set(PAGES)


def executables():
    """Module and function of each command, by package and name, as setup.py has them."""
    found = {}
    for package in ("evodevo_sim", "evodevo_ga"):
        for name, module in re.findall(r'"(\w+) = ([\w.]+:\w+)"', (ROOT / "src" / package / "setup.py").read_text()):
            found[package, name] = module
    return found


@pytest.fixture(scope="module")
def helps():
    """What each command says to --help, by its name."""
    code = "import importlib, sys; module, function = sys.argv.pop(1).split(':'); sys.argv[0] = 'command'; "
    code += "getattr(importlib.import_module(module), function)()"
    wide = {**os.environ, "COLUMNS": "300"}
    running = {
        name: subprocess.Popen([sys.executable, "-c", code, module, "--help"], stdout=subprocess.PIPE, text=True, env=wide)
        for (_, name), module in executables().items()
    }
    return {name: process.communicate(timeout=60)[0] for name, process in running.items()}


def wrong_flags(line, helps):
    """Flags in a line of a shell that the command before them does not have."""
    wrong = []
    for call in re.split(r"[;&|#\n`$]", line):
        found = re.search(r"(?:ros2 run \w+ |^\s*)(\w+)\b(.*)", call)
        if found and found[1] in helps:
            given = found[2].partition("--ros-args")[0]
            wrong += [f"{found[1]} {flag}" for flag in re.findall(r"(?<!\S)\(?(--[a-z][\w-]*)", given) if not has(helps[found[1]], flag)]
    return wrong


def has(text, flag):
    return re.search(rf"{flag}(?![\w-])", text) is not None


def test_commands_and_their_flags_exist(helps):
    known = executables()
    assert all(helps.values()), helps
    wrong = []
    for page, text in TEXT.items():
        joined = text.replace("\\\n", " ")
        wrong += [f"{page.name}: {found}" for found in re.findall(r"ros2 run (\w+) (\w+)", joined) if tuple(found) not in known]
        shell = [line for _, code in fences(joined) for line in code.splitlines()] + re.findall(r"`([^`]+)`", without_fences(joined))
        wrong += [f"{page.name}: {flag}" for line in shell for flag in wrong_flags(" ".join(line.split()), helps)]
    assert wrong == []
    commands = page_text("docs/reference/commands.md")
    assert [name for package, name in known if f"`ros2 run {package} {name}`" not in commands] == []


def test_studies_that_pages_name_have_the_flags_that_they_show():
    wrong = []
    for page, text in TEXT.items():
        for script, rest in re.findall(r"python ((?:benchmarks|scripts|examples)/[\w/]+\.py)([^`#\n]*)", text.replace("\\\n", " ")):
            source = (ROOT / script).read_text(encoding="utf-8") + (ROOT / "benchmarks/common.py").read_text(encoding="utf-8")
            wrong += [f"{page.name}: {script} {flag}" for flag in re.findall(r"(?<!\S)(--[a-z][\w-]*)", rest) if f'"{flag}"' not in source]
    assert wrong == []


def test_parameters_of_the_page_are_those_of_the_code():
    spec = importlib.util.spec_from_file_location("parameters_page", ROOT / "scripts" / "parameters.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    assert module.PAGE.read_text(encoding="utf-8") == module.page(), "run python scripts/parameters.py"
    rows = re.findall(r"^\| `([\w.]+)` \|.*\| .+ \|$", module.page(), re.MULTILINE)
    assert set(module.ORIGINS) <= set(rows)


def test_messages_of_the_page_are_those_of_the_code():
    text = page_text("docs/reference/messages.md")
    types = {file.stem for file in (ROOT / "src/evodevo_msgs").rglob("*.?[sr][gv]")}
    listed = text[text.index("## All types"):]
    assert {name for name in re.findall(r"`(\w+)`", listed) if name[0].isupper()} == types


def test_pages_that_code_names_exist():
    """In help texts, docstrings and scripts."""
    wrong = []
    for folder in ("src", "benchmarks", "scripts", "tests", "examples"):
        for file in (ROOT / folder).rglob("*"):
            if file.suffix in {".py", ".msg", ".srv", ".txt", ".sh"} and file != Path(__file__) and "build" not in file.parts:
                named = set(re.findall(r"\bdocs/[\w/-]+\.md", file.read_text(encoding="utf-8")))
                wrong += [f"{file.relative_to(ROOT)}: {name}" for name in sorted(named) if not (ROOT / name).exists()]
    assert not wrong

"""Finding one's way: what shells complete is what the parsers have, and every help has an example that works as it stands."""

import importlib.util
import itertools
import os
import re
import shlex
import shutil
import subprocess
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
from ament_index_python.packages import get_package_prefix

ROOT = Path(__file__).resolve().parents[1]
HERE = ROOT / "src/evodevo_sim/completion"
_spec = importlib.util.spec_from_file_location("completion", ROOT / "scripts" / "completion.py")
completion = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(completion)
PARSERS = {
    (package, name): completion.parser_of(entry) for package in completion.PACKAGES for name, entry in completion.commands(package).items()
}
# What follows is made, or is a device, and need not be there.
RESULTS = {"-o", "--out", "--save", "--picture", "--png", "--csv", "--npz", "--link", "--port", "--calibration"}
RUN = ("request", "figure")  # whose examples are so cheap that they run here; of the others the parser takes them


# --- completion ------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("package", completion.PACKAGES)
def test_words_are_those_of_the_parsers(package):
    assert completion.file_of(package).read_text() == completion.text(package), "run python scripts/completion.py"


def bash(*words, before=""):
    line = " ".join(map(shlex.quote, words))
    sources = " ".join(f". {shlex.quote(str(completion.file_of(package)))};" for package in completion.PACKAGES)
    script = (
        f"{before} {sources} . {shlex.quote(str(HERE / 'evodevo.bash'))}; COMP_WORDS=({line}); COMP_CWORD={len(words) - 1}; "
        '_evodevo_ros2 ros2; printf "%s\\n" "${COMPREPLY[@]}"'
    )
    done = subprocess.run(["bash", "--norc", "-c", script], capture_output=True, text=True, cwd=ROOT, check=True)
    assert not done.stderr
    return done.stdout.split()


def zsh(*words, before=""):
    line = " ".join(map(shlex.quote, words))
    sources = " ".join(f". {shlex.quote(str(completion.file_of(package)))};" for package in completion.PACKAGES)
    script = (
        f"{sources} . {shlex.quote(str(HERE / 'evodevo.zsh'))}; {before} words=({line}); CURRENT={len(words)}; "
        'compadd() { shift; print -l -- "$@" }; _files() { print -l -- *(N) }; _evodevo_ros2'
    )
    done = subprocess.run(["zsh", "-f", "-c", script], capture_output=True, text=True, cwd=ROOT, check=True)
    assert not done.stderr
    current = words[-1]
    return [word for word in done.stdout.split() if word.startswith(current)]


SHELLS = [
    pytest.param(bash, id="bash"),
    pytest.param(zsh, id="zsh", marks=pytest.mark.skipif(not shutil.which("zsh"), reason="zsh is not installed: apt install zsh")),
]


@pytest.mark.parametrize("shell", SHELLS)
def test_a_shell_completes_packages_commands_options_choices_and_files(shell):
    assert set(shell("ros2", "run", "")) >= {"evodevo_sim", "evodevo_ga"}
    assert set(shell("ros2", "run", "evodevo_ga", "")) == {name for package, name in PARSERS if package == "evodevo_ga"}
    assert shell("ros2", "run", "evodevo_sim", "gai") == ["gait"]
    assert shell("ros2", "run", "evodevo_sim", "gait", "--pal") == ["--palette"]
    assert set(shell("ros2", "run", "evodevo_sim", "gait", "--palette", "")) == {"paper", "safe"}
    assert set(shell("ros2", "run", "evodevo_sim", "figure", "")) >= {"growth", "turning"}
    assert "bags" in shell("ros2", "run", "evodevo_sim", "film", "ba")
    assert "bags" in shell("ros2", "run", "evodevo_sim", "figure", "gait", "ba")
    assert "walk" in shell("ros2", "run", "evodevo_ga", "evolve", "--task", "")
    assert shell("ros2", "run", "evodevo_ga", "evolve", "--seed", "") == []


def test_what_completed_ros2_before_completes_all_else():
    before = 'their() { COMPREPLY=(theirs); }; complete -F their ros2;'
    assert bash("ros2", "topic", "", before=before) == ["theirs"] and bash("ros2", "run", "turtlesim", "", before=before) == ["theirs"]
    assert bash("ros2", "run", "evodevo_sim", "gai", before=before) == ["gait"]


def test_a_shell_in_which_one_types_has_it_after_env_sh():
    script = f". {shlex.quote(str(ROOT / 'scripts/env.sh'))}; complete -p ros2; compgen -v _evodevo"
    environment = {name: value for name, value in os.environ.items() if name in ("HOME", "PATH")}
    done = subprocess.run(["bash", "--norc", "-i", "-c", script], capture_output=True, text=True, env=environment)
    assert "-F _evodevo_ros2 ros2" in done.stdout and done.stdout.split()[-1] in ("ros2", "_evodevo_before"), done.stdout


# --- examples --------------------------------------------------------------------------------------------------------------


def lines(command):
    """The words of each line of a help that runs something of ours, by itself."""
    found = (line.strip() for line in PARSERS[command].format_help().splitlines())
    return [shlex.split(line)[2:] for line in found if re.match(r"ros2 run evodevo_\w+ \w+", line)]


def examples(command):
    """The arguments of the lines of a help that run the command."""
    return [words[2:] for words in lines(command) if tuple(words[:2]) == command]


def made(command):
    """What the lines of a help leave behind."""
    return {word for words in lines(command) for before, word in itertools.pairwise(words) if before in RESULTS}


def stands(arguments, made=()):
    """Whether all that an example reads is there, or made by another line of the same help."""
    read = [word for before, word in zip(["", *arguments], arguments) if before not in RESULTS]
    paths = [word for word in read if re.fullmatch(r"[\w./-]+", word) and ("/" in word or word.endswith((".yaml", ".csv")))]
    return all((ROOT / path).exists() or path in made for path in paths if not path.startswith("-"))


@pytest.mark.parametrize("command", PARSERS, ids=lambda command: command[1])
def test_every_help_has_an_example_that_works_as_it_stands(command):
    standing = [arguments for arguments in examples(command) if stands(arguments, made(command))]
    assert standing, "give an example with files that are in the repository, e.g. bags/sample-swim"
    for arguments in examples(command):
        cut = arguments[: arguments.index("--ros-args")] if "--ros-args" in arguments else arguments
        PARSERS[command].parse_args(cut)  # it leaves where it takes none of them


def test_what_is_wrong_is_seen():
    assert not stands(["bags/nowhere", "-o", "a.html"]) and not stands(["champion.yaml"]) and stands(["bags/sample-swim", "--out", "x/y"])


def test_cheap_examples_run(tmp_path):
    for name in ("bags", "examples", "src"):
        (tmp_path / name).symlink_to(ROOT / name)

    def run(name):
        arguments = next(one for one in examples(("evodevo_sim", name)) if stands(one))
        program = Path(get_package_prefix("evodevo_sim"), "lib", "evodevo_sim", name)
        return subprocess.run([program, *arguments], cwd=tmp_path, capture_output=True, text=True)

    with ThreadPoolExecutor(2) as pool:
        for name, done in zip(RUN, pool.map(run, RUN)):
            assert done.returncode == 0, (name, done.stderr)
    assert {path.name for path in tmp_path.iterdir()} == {"bags", "examples", "src", "fitness.pdf"}

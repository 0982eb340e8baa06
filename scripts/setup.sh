#!/usr/bin/env bash
# Set-up: the environment in .venv, then the packages in ros_ws/install.  What is in place is left alone; what was
# interrupted is made again.  PYTHON=... chooses the interpreter.
set -e
cd "$(dirname "${BASH_SOURCE[0]}")/.."
unset PYTHONHOME PYTHONPATH VIRTUAL_ENV _ROS_WHEELS_BOOTSTRAP_COMPLETE
root="$PWD"
log="$root/setup.log"
environment_stamp=.venv/.complete
stamps=ros_ws/install/.complete

say() { echo "evodevo: $*"; }
fail() { echo "evodevo: $*" >&2; exit 1; }

# Run a command in a process group of its own, with its output in the log, whose end is shown if it fails.
quietly() {
    echo "+ $*" >>"$log"
    set -m
    "$@" >>"$log" 2>&1 </dev/null &
    child=$!
    set +m
    wait $child && return
    tail -n 30 "$log" >&2
    fail "set-up failed in: ${*:0:5} ...; the end of its output is above, all of it in setup.log; mend the cause and run the same again"
}

interrupted() {
    [ -z "$child" ] || kill -- "-$child" 2>/dev/null || true
    say "interrupted; the same command goes on from here" >&2
    exit 130
}

# --- the machine -------------------------------------------------------------------------------------------------------

check_machine() {
    [ "$(uname -sm)" = "Linux x86_64" ] || fail "the ROS 2 wheels are for Linux on x86-64, not $(uname -sm): build src/ in a ROS 2 Jazzy workspace instead"
    [ -n "$(type -p "${CXX:-c++}" g++ clang++)" ] || fail "a C++ compiler is needed (Debian, Ubuntu: apt install g++)"
}

# Prints the path of an interpreter that will do, or fails with the reason against it.
probe='
import os, sys, sysconfig
if not (3, 11) <= sys.version_info[:2] <= (3, 13): sys.exit("is %d.%d" % sys.version_info[:2])
try: import ensurepip, venv
except ImportError: sys.exit("has no venv (Debian, Ubuntu: apt install python3-venv)")
headers = sysconfig.get_path("include")
if not os.path.exists(os.path.join(headers, "Python.h")): sys.exit("has no C headers (Debian, Ubuntu: apt install python3-dev)")
print(sys._base_executable)
'

find_python() {
    local candidates candidate answer reasons=
    mapfile -t candidates < <(if [ -n "$PYTHON" ]; then echo "$PYTHON"; else type -ap python3.{12,13,11} python3; fi)
    for candidate in "${candidates[@]}"; do
        answer="$("$candidate" -c "$probe" 2>&1)" && { echo "$answer"; return; }
        [[ $answer =~ ^(is|has) ]] && reasons+="$candidate $answer; "
    done
    [ -z "$PYTHON" ] || reasons="${reasons:-$PYTHON does not run; }"
    fail "no Python 3.11, 3.12 or 3.13 with venv and C headers: ${reasons}install one, or name it with PYTHON=/path/to/python3"
}

# --- the environment ---------------------------------------------------------------------------------------------------

# What an environment is made from; a change in any of it, or of the directory, makes it anew.
environment_recipe() {
    echo "$(cat requirements.lock scripts/fix_wheels.py | sha256sum) Python $(sed -n 's/^version = //p' .venv/pyvenv.cfg) $root"
}

environment_in_place() {
    [ -x .venv/bin/python ] && [ -e $environment_stamp ] && [ "$(<$environment_stamp)" = "$(environment_recipe)" ] || return
    [ -z "$PYTHON" ] || [[ $(<$environment_stamp) == *" $("$PYTHON" -V 2>&1 || echo none) "* ]]
}

make_environment() {
    local python install=(.venv/bin/python -m pip install --no-deps --require-hashes --no-input --disable-pip-version-check)
    check_machine
    python="$(find_python)"
    say "installing ROS 2 and Python packages into .venv with $("$python" -V): 1 to 3 minutes, 1.6 GB"
    rm -rf .venv
    quietly "$python" -m venv .venv
    # setuptools first, from the lock too: it builds the one package that has no wheel.
    sed -n '/^setuptools==/,/[^\\]$/p' requirements.lock >.venv/setuptools.lock
    quietly "${install[@]}" -r .venv/setuptools.lock
    quietly "${install[@]}" --no-build-isolation --use-pep517 -r requirements.lock
    quietly .venv/bin/python scripts/fix_wheels.py
    environment_recipe >$environment_stamp
}

# --- the packages ------------------------------------------------------------------------------------------------------

# What a package's build depends on.  Python modules and YAML files are linked, not copied: changes in them need no build,
# new YAML files do.
package_recipe() {
    find "src/$1" -regex '.*/\(msg\|srv\|champions\)/.*' | sort \
        | cat - "src/$1"/{package.xml,setup.py,setup.cfg,CMakeLists.txt,msg/*,srv/*} 2>/dev/null | sha256sum
}

# Whether a build without --symlink-install put copies of the Python modules where the links were.
has_copies() {
    [ -e "src/$1/setup.py" ] && compgen -G "ros_ws/install/$1/lib/python*/site-packages/$1" >/dev/null
}

build_packages() {
    local package changed
    local -A recipe
    cmp -s $environment_stamp $stamps/environment || rm -rf ros_ws/build ros_ws/install
    for package in evodevo_msgs evodevo_sim evodevo_ga; do
        recipe[$package]="$(package_recipe $package)"  # of what stands before the build: an edit during it counts as a change
        if [ ! -e $stamps/$package ] || has_copies $package; then
            rm -rf ros_ws/{build,install}/$package $stamps/$package
        fi
        [ "$(cat $stamps/$package 2>/dev/null)" = "${recipe[$package]}" ] || changed+="$package "
    done
    [ -n "$changed" ] || return 0

    check_machine
    say "building ${changed% }: 5 to 60 seconds"
    mkdir -p $stamps
    cp $environment_stamp $stamps/environment
    (cd $stamps && rm -f $changed)
    cd ros_ws
    quietly ../scripts/run.sh colcon build --symlink-install --packages-select $changed
    cd ..
    for package in $changed; do echo "${recipe[$package]}" >$stamps/$package; done
}

# -----------------------------------------------------------------------------------------------------------------------

exec 9<scripts/setup.sh  # one set-up at a time
flock -n 9 || { say "waiting for another set-up in this directory to end"; flock 9; }
trap interrupted INT TERM HUP
if ! environment_in_place; then
    : >"$log"
    make_environment
fi
build_packages

#!/usr/bin/env bash
# Install the other engines of benchmarks/peers.py into .venv.  Nothing that requirements.lock holds changes its version.
set -e
cd "$(dirname "${BASH_SOURCE[0]}")/.."
constraints="$(mktemp)"
trap 'rm -f "$constraints"' EXIT
scripts/constraints.sh >"$constraints"
.venv/bin/python -m pip install --quiet --no-input --disable-pip-version-check -c "$constraints" -r benchmarks/requirements-peers.txt
echo "evodevo: the other engines are installed; measure them:   make bench ARGS=\"--only peers\""

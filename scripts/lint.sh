#!/usr/bin/env bash
# The linter and the type checker, with the settings of pyproject.toml: some 15 seconds, one when little has changed.
cd "$(dirname "${BASH_SOURCE[0]}")/.."
status=0
ruff check --quiet src tests benchmarks scripts examples || status=1
mypy --no-error-summary || status=1
[ $status = 0 ] && echo "ruff and mypy: nothing to mend"
exit $status

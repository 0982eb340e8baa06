#!/usr/bin/env bash
# Pin requirements.in, with what it stands on, in requirements.lock: CPython 3.11 to 3.13, Linux, with hashes.
set -e
cd "$(dirname "${BASH_SOURCE[0]}")/.."
tool="$(mktemp -d)"
trap 'rm -rf "$tool"' EXIT
.venv/bin/python -m venv "$tool"
"$tool/bin/python" -m pip install --quiet uv
env -u UV_FIND_LINKS -u UV_INDEX_URL -u UV_EXTRA_INDEX_URL "$tool/bin/uv" pip compile --quiet --upgrade --universal \
    --python-version 3.11 --generate-hashes --no-emit-index-url --no-header --no-annotate requirements.in -o requirements.lock

#!/usr/bin/env bash
# Print the versions in requirements.lock without their hashes, as constraints for packages that the lock does not hold:
# one hash in a file of constraints makes pip ask for hashes of everything that it installs.
sed -e 's/ *\\$//' -e '/^ *--hash=/d' "$(dirname "${BASH_SOURCE[0]}")/../requirements.lock"

#!/usr/bin/env bash
# Run a command in the project's environment alone, whatever ROS the calling shell holds:
#   scripts/run.sh COMMAND [ARGUMENT ...]
unset AMENT_PREFIX_PATH CMAKE_PREFIX_PATH COLCON_PREFIX_PATH PYTHONHOME PYTHONPATH RMW_IMPLEMENTATION ROS_DISTRO
here="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)"
. "$here/env.sh" || exit 1
PATH="$VIRTUAL_ENV/bin:$here/bin:$PATH"
exec "$@"

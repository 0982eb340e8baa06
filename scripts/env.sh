# The project's environment for this shell (bash or zsh):  source scripts/env.sh

_evodevo_here="${BASH_SOURCE[0]:-$0}"
_evodevo_root="$(cd "$(dirname "$_evodevo_here")/.." && pwd)"
_evodevo_venv="$_evodevo_root/.venv"
_evodevo_setup="$_evodevo_root/ros_ws/install/setup.${ZSH_VERSION:+z}${BASH_VERSION:+ba}sh"

if [ ! -e "$_evodevo_venv/bin/python" ]; then
    echo "evodevo: nothing is installed yet: run 'make setup' in $_evodevo_root" >&2
    unset _evodevo_here _evodevo_root _evodevo_venv _evodevo_setup
    return 1
fi

# The environment first; the stand-in for `ros2` last, so that a real one goes before it.
case ":$PATH:" in
    ":$_evodevo_venv/bin:"*) ;;
    *) PATH="$_evodevo_venv/bin:$PATH" ;;
esac
case ":$PATH:" in
    *":$_evodevo_root/scripts/bin:"*) ;;
    *) PATH="$PATH:$_evodevo_root/scripts/bin" ;;
esac
export PATH
export VIRTUAL_ENV="$_evodevo_venv"  # CMake looks for Python here first

# colcon and ament find packages through these; message definitions are found through the first at run time too.
case ":${AMENT_PREFIX_PATH:-}:" in
    *":$_evodevo_venv:"*) ;;
    *) export AMENT_PREFIX_PATH="$_evodevo_venv${AMENT_PREFIX_PATH:+:$AMENT_PREFIX_PATH}" ;;
esac
case ":${CMAKE_PREFIX_PATH:-}:" in
    *":$_evodevo_venv:"*) ;;
    *) export CMAKE_PREFIX_PATH="$_evodevo_venv${CMAKE_PREFIX_PATH:+:$CMAKE_PREFIX_PATH}" ;;
esac

# The ROS wheels set library paths once per process tree, under this guard; another environment's must not count here.
unset _ROS_WHEELS_BOOTSTRAP_COMPLETE

# Nodes talk to this host only, unless another range is chosen.
export ROS_AUTOMATIC_DISCOVERY_RANGE="${ROS_AUTOMATIC_DISCOVERY_RANGE:-LOCALHOST}"

if [ -e "$_evodevo_setup" ]; then
    . "$_evodevo_setup"
fi

# What the tabulator completes after `ros2 run`, where a person types.
case "$-" in
    *i*)
        for _evodevo_file in evodevo_sim/share/evodevo_sim/completion/evodevo_sim.sh evodevo_ga/share/evodevo_ga/completion/evodevo_ga.sh \
            "evodevo_sim/share/evodevo_sim/completion/evodevo.${ZSH_VERSION:+z}${BASH_VERSION:+ba}sh"; do
            if [ -e "$_evodevo_root/ros_ws/install/$_evodevo_file" ]; then
                . "$_evodevo_root/ros_ws/install/$_evodevo_file"
            fi
        done
        unset _evodevo_file
        ;;
esac
unset _evodevo_here _evodevo_root _evodevo_venv _evodevo_setup

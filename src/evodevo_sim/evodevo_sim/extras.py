"""What is installed only with an extra: the line that says which."""

from __future__ import annotations

_EXTRAS = {
    "scipy": "gaits", "serial": "hardware", "cobs": "hardware",
    "matplotlib": "view", "mpl_toolkits": "view", "rerun": "view", "rerun_cli": "view", "rerun_bindings": "view",
    "av": "view", "PIL": "view",
    "pyarrow": "evodevo_ga[ros]", "mcap": "ros", "mcap_ros2": "ros", "zstandard": "ros", "rich": "ros", "tqdm": "ros",
    "rclpy": "ros", "ament_index_python": "ros", "builtin_interfaces": "ros", "geometry_msgs": "ros", "rcl_interfaces": "ros",
    "diagnostic_msgs": "ros", "sensor_msgs": "ros", "std_msgs": "ros", "std_srvs": "ros", "visualization_msgs": "ros",
    "distributed": "evodevo_ga[dask]", "dask": "evodevo_ga[dask]",
}


def lacking(error: ModuleNotFoundError) -> ModuleNotFoundError:
    """The same error with the line that says what to install; as it is where no extra of ours would bring the module."""
    name = (error.name or "").partition(".")[0]
    if name == "evodevo_msgs":
        return ModuleNotFoundError("evodevo_msgs is not installed: build it with colcon, as README tells", name=error.name)
    if name not in _EXTRAS:
        return error
    extra = _EXTRAS[name]
    whole = extra if "[" in extra else f"evodevo_sim[{extra}]"
    return ModuleNotFoundError(f"{name} is not installed: pip install '{whole}'", name=error.name)

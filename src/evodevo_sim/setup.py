from glob import glob
from xml.etree import ElementTree

from setuptools import find_packages, setup

package_name = "evodevo_sim"

setup(
    name=package_name,
    version=ElementTree.parse("package.xml").findtext("version"),
    packages=find_packages(exclude=["test"]),
    package_data={
        package_name: [
            "ros/discovery.xml", "py.typed", "recording/before/*.msg", "champions/*.yaml", "layouts/*", "view/film/*.css", "view/film/*.js",
        ],
    },
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{package_name}"]),
        (f"share/{package_name}", ["package.xml"]),
        (f"share/{package_name}/champions", sorted(glob("champions/*.yaml"))),
        (f"share/{package_name}/completion", sorted(glob("completion/*"))),
        (f"share/{package_name}/layouts", sorted(glob(f"{package_name}/layouts/*"))),
        (f"share/{package_name}/launch", sorted(glob("launch/*.launch.py"))),
    ],
    install_requires=["numpy>=2", "numba", "PyYAML"],
    extras_require={
        "gaits": ["scipy"],
        "hardware": ["pyserial", "cobs"],
        "view": ["matplotlib", "rerun-sdk", "pillow", "av"],
        "ros": [
            "mcap", "mcap-ros2-support", "zstandard", "rich", "tqdm",
            "ros-jazzy-rclpy>=7.1.4", "ros-jazzy-common-interfaces", "ros-jazzy-rmw-fastrtps-cpp",
        ],
        "test": ["pytest", "pytest-timeout", "hypothesis", "rosbags"],
    },
    python_requires=">=3.11",
    zip_safe=False,
    maintainer="evodevo contributors",
    maintainer_email="maintainers@evodevo.dev",
    description="Growth of soft robots from genomes, their physics, the simulator node, recording and replay.",
    license="MIT",
    entry_points={
        "console_scripts": [
            "simulator = evodevo_sim.commands.entry:simulator",
            "audit = evodevo_sim.commands.entry:audit",
            "simulate = evodevo_sim.commands.entry:simulate",
            "figure = evodevo_sim.commands.entry:figure",
            "film = evodevo_sim.commands.entry:film",
            "gait = evodevo_sim.commands.entry:gait",
            "compare = evodevo_sim.commands.entry:compare",
            "identify = evodevo_sim.commands.entry:identify",
            "info = evodevo_sim.commands.entry:info",
            "replay = evodevo_sim.commands.entry:replay",
            "conform = evodevo_sim.commands.entry:conform",
            "driver = evodevo_sim.commands.entry:driver",
            "emulate = evodevo_sim.commands.entry:emulate",
            "chase = evodevo_sim.commands.entry:chase",
            "request = evodevo_sim.commands.entry:request",
            "turning = evodevo_sim.commands.entry:turning",
        ],
    },
)

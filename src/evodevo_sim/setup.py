from glob import glob

from setuptools import find_packages, setup

package_name = "evodevo_sim"

setup(
    name=package_name,
    version="0.1.0",
    packages=find_packages(exclude=["test"]),
    package_data={package_name: ["ros/discovery.xml"]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{package_name}"]),
        (f"share/{package_name}", ["package.xml"]),
        (f"share/{package_name}/champions", sorted(glob("champions/*.yaml"))),
    ],
    install_requires=["setuptools"],
    extras_require={"test": ["pytest"]},
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
            "gait = evodevo_sim.commands.entry:gait",
            "replay = evodevo_sim.commands.entry:replay",
            "chase = evodevo_sim.commands.entry:chase",
            "turning = evodevo_sim.commands.entry:turning",
        ],
    },
)

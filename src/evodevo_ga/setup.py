from glob import glob
from xml.etree import ElementTree

from setuptools import find_packages, setup

package_name = "evodevo_ga"

setup(
    name=package_name,
    version=ElementTree.parse("package.xml").findtext("version"),
    packages=find_packages(exclude=["test"]),
    package_data={package_name: ["py.typed", "report/*.css"]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{package_name}"]),
        (f"share/{package_name}", ["package.xml"]),
        (f"share/{package_name}/completion", sorted(glob("completion/*"))),
        (f"share/{package_name}/launch", sorted(glob("launch/*.launch.py"))),
    ],
    install_requires=["numpy>=2", "ribs", "evodevo_sim"],
    extras_require={
        "ros": ["evodevo_sim[gaits,ros]", "pyarrow"],
        "view": ["evodevo_sim[view]", "matplotlib"],
        "dask": ["distributed"],
        "test": ["pytest", "pytest-timeout", "hypothesis"],
    },
    python_requires=">=3.11",
    zip_safe=False,
    maintainer="evodevo contributors",
    maintainer_email="maintainers@evodevo.dev",
    description="Genetic algorithm over evodevo genomes and its node, which evaluates through simulators.",
    license="MIT",
    entry_points={
        "console_scripts": [
            "evolve = evodevo_ga.commands:evolve",
            "report = evodevo_ga.commands:report",
            "gallery = evodevo_ga.commands:gallery",
            "descent = evodevo_ga.commands:descent",
            "status = evodevo_ga.commands:status",
        ],
    },
)

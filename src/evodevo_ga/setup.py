from setuptools import find_packages, setup

package_name = "evodevo_ga"

setup(
    name=package_name,
    version="0.1.0",
    packages=find_packages(exclude=["test"]),
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{package_name}"]),
        (f"share/{package_name}", ["package.xml"]),
    ],
    install_requires=["setuptools"],
    extras_require={"test": ["pytest"]},
    zip_safe=False,
    maintainer="evodevo contributors",
    maintainer_email="maintainers@evodevo.dev",
    description="Genetic algorithm over evodevo genomes and its node, which evaluates through simulators.",
    license="MIT",
    entry_points={
        "console_scripts": [
            "evolve = evodevo_ga.commands:evolve",
        ],
    },
)

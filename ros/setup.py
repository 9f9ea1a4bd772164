"""The ament_python package fuzzyfleet_ros: colcon builds it, and pip installs it too."""

from glob import glob

from setuptools import setup

_NAME = "fuzzyfleet_ros"

setup(
    name=_NAME,
    version="1.0.0rc1",
    description="Drives a robot by any law of Fuzzyfleet, and its simulator as a loopback with wheel dynamics",
    author="The Fuzzyfleet developers",
    license="MIT",
    packages=[_NAME],
    python_requires=">=3.11",
    install_requires=["setuptools"],
    zip_safe=True,
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{_NAME}"]),
        (f"share/{_NAME}", ["package.xml"]),
        *(
            (f"share/{_NAME}/{folder}", sorted(glob(f"{folder}/*")))
            for folder in ("config", "foxglove", "launch", "rviz")
        ),
    ],
    entry_points={
        "console_scripts": [
            f"{command} = {_NAME}.{command}:main"
            for command in ("controller", "excite", "fleet", "identify", "simulator")
        ]
    },
)

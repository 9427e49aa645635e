"""The ament_python package of the explorer as a ROS 2 node; it has not been built or run with ROS here."""

from setuptools import setup

NAME = "indoor_explorers_ros"

setup(
    name=NAME,
    version="0.3.0",
    packages=[NAME],
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{NAME}"]),
        (f"share/{NAME}", ["package.xml"]),
        (f"share/{NAME}/launch", ["launch/explore_launch.py"]),
    ],
    install_requires=["setuptools"],
    entry_points={"console_scripts": [f"explorer = {NAME}.explorer_node:main"]},
)

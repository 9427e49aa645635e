"""The ROS 2 package: its node with stand-ins for the modules of ROS, which is not installed here."""

import importlib.util
import runpy
import sys
from types import SimpleNamespace
from unittest.mock import MagicMock
from xml.etree import ElementTree

import numpy as np
import pytest

from tests.documents import ROOT
from tests.evaluation.robot.room import grid_of

PACKAGE = ROOT / "evaluation" / "site" / "ros2_package"
ROS = (
    *("rclpy", "action_msgs", "geometry_msgs", "nav2_msgs", "nav_msgs", "std_msgs", "tf2_ros"),
    *("visualization_msgs", "launch", "launch_ros"),
)


class Node:
    """What the node uses of rclpy's."""

    def __init__(self, name):
        self.created = {}

    def declare_parameter(self, name, default):
        return SimpleNamespace(value=1.0 if name == "cell" else default)

    def create_subscription(self, kind, name, function, quality):
        self.created[name] = function

    def create_publisher(self, kind, name, quality):
        self.created[name] = MagicMock()
        return self.created[name]

    def create_timer(self, period, function):
        pass

    def get_logger(self):
        return MagicMock()


@pytest.fixture
def module(monkeypatch):
    """The node's module."""
    for name in ROS:
        for part in (name, f"{name}.action", f"{name}.actions", f"{name}.msg", f"{name}.node", f"{name}.qos"):
            monkeypatch.setitem(sys.modules, part, MagicMock())
    monkeypatch.setitem(sys.modules, "launch.substitutions", MagicMock())
    sys.modules["rclpy.node"].Node = Node
    sys.modules["tf2_ros"].TransformException = KeyError
    spec = importlib.util.spec_from_file_location("node", PACKAGE / "indoor_explorers_ros" / "explorer_node.py")
    made = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(made)
    return made


def test_the_node_sends_goals_and_hears_of_their_ends(module):
    node = module.ExplorerNode()
    values = np.full((8, 8), -1)
    values[2:6, 2:6] = 0
    node.created["map"](grid_of(values, 1.0))
    upright = SimpleNamespace(x=0.0, y=0.0, z=0.0, w=1.0)
    moved = SimpleNamespace(translation=SimpleNamespace(x=3.5, y=3.5), rotation=upright)
    node.buffer.lookup_transform.return_value = SimpleNamespace(transform=moved)
    node.tick()
    assert node.explorer.status == "exploring"
    first = node.goal
    assert node.explorer.target is not None
    node.accepted(SimpleNamespace(accepted=False), first)
    assert "navigation refused it" in node.explorer.status
    node.tick()
    assert node.goal[:2] != first[:2]
    node.ended(-1, first)  # of an old goal
    assert node.explorer.target is not None
    node.show()
    (array,) = node.created["explore/frontiers"].publish.call_args.args
    assert array.markers.append.call_count == 4
    handle = MagicMock(accepted=True)
    node.accepted(handle, node.goal)
    node.created["explore/resume"](SimpleNamespace(data=False))
    node.tick()
    handle.cancel_goal_async.assert_called_once()


def test_the_package_lists_what_it_has(module, monkeypatch):
    made = MagicMock()
    monkeypatch.setattr(pytest.importorskip("setuptools"), "setup", made)
    monkeypatch.chdir(PACKAGE)
    runpy.run_path(str(PACKAGE / "setup.py"))
    facts = made.call_args.kwargs
    assert all((PACKAGE / file).is_file() for _, files in facts["data_files"] for file in files)
    assert (PACKAGE / facts["packages"][0] / "explorer_node.py").is_file()
    root = ElementTree.parse(PACKAGE / "package.xml").getroot()
    assert root.findtext("name") == facts["name"]
    assert root.findtext("version") == facts["version"]
    assert callable(runpy.run_path(str(PACKAGE / "launch" / "explore_launch.py"))["generate_launch_description"])

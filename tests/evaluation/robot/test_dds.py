"""Robots and explorers in processes of their own, over DDS on the loopback interface, without multicast."""

import os
import queue
import signal
import subprocess
import sys
import threading
import time

import pytest

pytest.importorskip("cyclonedds")

from indoor_explorers.evaluation.cli.parser import main
from indoor_explorers.evaluation.robot.messages import DEFINITIONS, new, type_of

LOOPBACK = (
    "<CycloneDDS><Domain><General><Interfaces><NetworkInterface name='lo' multicast='false'/></Interfaces>"
    "<AllowMulticast>false</AllowMulticast></General><Discovery><ParticipantIndex>auto</ParticipantIndex>"
    "<MaxAutoParticipantIndex>40</MaxAutoParticipantIndex>"
    "<Peers><Peer address='localhost'/></Peers></Discovery></Domain></CycloneDDS>"
)
#: The building: a room of the thesis with obstacles, in which a robot sees 5 m far and drives faster than any real one.
BUILDING = "robot simulate --scenario thesis-obstacles --set lidar.range=5 map.height=11 map.width=11"
EXPLORER = "robot --cell 1 --radius 0.3 --lidar 5 --settle 1.5 --silence 3"
CODE = "import sys; from indoor_explorers.evaluation.cli import main; sys.exit(main())"
DONE = "done: no frontier is left"
pytestmark = pytest.mark.xdist_group("dds")


class Process:
    """A command of the package; its lines are read as they come."""

    def __init__(self, words, domain, code=CODE):
        environment = os.environ | {"CYCLONEDDS_URI": LOOPBACK, "ROS_DOMAIN_ID": str(domain), "PYTHONUNBUFFERED": "1"}
        self.child = subprocess.Popen(
            [sys.executable, "-P", "-c", code, *words.split()],
            env=environment,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        )
        self.lines = []
        self._arriving = queue.Queue()
        threading.Thread(target=self._read, daemon=True).start()

    def _read(self):
        for line in self.child.stdout:
            self._arriving.put(line.strip())

    def says(self, text, within=40.0):
        """Wait for a line that has a text in it."""
        end = time.monotonic() + within
        while time.monotonic() < end:
            try:
                self.lines.append(self._arriving.get(timeout=max(end - time.monotonic(), 0.01)))
            except queue.Empty:
                break
            if text in self.lines[-1]:
                return self.lines[-1]
        raise AssertionError(f"no {text!r} within {within} s in {self.lines}")

    def end(self, how=signal.SIGKILL):
        self.child.send_signal(how)
        return self.child.wait(60)


@pytest.fixture
def start():
    """Start processes in a domain of the test's own; all are ended after it."""
    domain = 30 + int.from_bytes(os.urandom(2), "big") % 150
    begun = []

    def begin(words, **more):
        begun.append(Process(words, domain, **more))
        return begun[-1]

    yield begin
    for each in begun:
        if each.child.poll() is None:
            each.end()
        each.child.stdout.close()


@pytest.mark.slow
@pytest.mark.parametrize("goals", ["topic", "action"])
def test_a_building_is_explored_until_it_is_done(goals, start):
    robot = start(f"{BUILDING} --speed 5")
    explorer = start(f"{EXPLORER} --goals {goals}")
    explorer.says("exploring")
    explorer.says(DONE)
    assert explorer.child.wait(10) == 0
    robot.says("100 % of the free cells known")
    assert not [line for line in explorer.lines if "banned" in line]


@pytest.mark.slow
def test_an_explorer_that_is_killed_is_started_again_and_goes_on(start):
    start(f"{BUILDING} --speed 4")
    first = start(EXPLORER)
    first.says("exploring")
    time.sleep(1.0)
    first.end()
    again = start(EXPLORER)
    again.says("exploring")
    again.says(DONE)


@pytest.mark.slow
def test_interrupting_stops_the_robot(start):
    start(f"{BUILDING} --speed 0.3")
    explorer = start(f"{EXPLORER} --goals action")
    explorer.says("exploring")
    time.sleep(1.0)
    assert explorer.end(signal.SIGINT) == 130
    explorer.says("interrupted; the robot was told to stop")


#: A mapper that is silent from the fifth to the tenth second.
MUTE = """
from indoor_explorers.env import scenario
from indoor_explorers.evaluation.robot.simulated import Simulation, simulate
building = scenario("thesis-obstacles").with_settings({"lidar.range": 5, "map.height": 11, "map.width": 11})
simulate(Simulation(scenario=building, speed=1.5, mute=(5, 10)), print)
"""
#: What an operator does: pause as soon as the robot explores, listen a little, and let it go on.
OPERATOR = """
import sys, time
from indoor_explorers.evaluation.robot.dds import Node, quality, taken
from indoor_explorers.evaluation.robot.messages import new
node = Node()
switch = node.writer("std_msgs/msg/Bool", "explore/resume", quality(10))
status = node.reader("std_msgs/msg/String", "explore/status", quality(1, latched=True))
shown = node.reader("visualization_msgs/msg/MarkerArray", "explore/frontiers", quality(1, latched=True))
marked = []
def wait(text):
    while True:
        marked.extend((each.ns, len(each.points)) for array in taken(shown) for each in array.markers)
        if any(each.data.startswith(text) for each in taken(status)):
            print("heard", text, flush=True)
            return
        time.sleep(0.05)
wait("exploring")
time.sleep(1.5)
switch.write(new("std_msgs/msg/Bool", data=False))
wait("paused")
switch.write(new("std_msgs/msg/Bool", data=True))
wait("exploring")
time.sleep(1.5)
wait("done")
print(sorted({name for name, count in marked if count}))
"""


@pytest.mark.slow
def test_a_silent_map_stops_the_robot_until_it_comes_back(start):
    start("", code=MUTE)
    explorer = start(EXPLORER)
    explorer.says("exploring")
    explorer.says("silent: no map for 3 s")
    explorer.says("exploring")
    explorer.says(DONE)


@pytest.mark.slow
def test_an_operator_pauses_and_resumes_and_sees_what_is_planned(start):
    start(f"{BUILDING} --speed 3")
    operator = start("", code=OPERATOR)
    start(f"{EXPLORER} --policy frontier-nearest --stay")
    operator.says("heard paused")
    operator.says("heard exploring")
    operator.says("heard done")
    assert operator.says("[") == "['candidates', 'frontiers', 'goal', 'plan']"


@pytest.mark.slow
@pytest.mark.parametrize("shared", [False, True])
def test_two_robots_explore_together(shared, start):
    start(f"{BUILDING} --speed 4 --robots tb1,tb2" + " --shared-map" * shared)
    more = "--robots tb1,tb2 --area=0,0,14,14 --policy frontier-joint --goals action" + " --map-topic /map" * shared
    robots = [start(f"{EXPLORER} {more} --name {name}") for name in ("tb1", "tb2")]
    for robot in robots:
        robot.says(DONE)


def test_messages_have_the_names_and_the_bytes_of_ros():
    assert type_of("nav_msgs/msg/OccupancyGrid").__idl_typename__ == "nav_msgs::msg::dds_::OccupancyGrid_"
    name = "nav2_msgs::action::dds_::NavigateToPose_SendGoal_Request_"
    assert type_of("nav2_msgs/action/NavigateToPose_SendGoal_Request").__idl_typename__ == name
    for kind in DEFINITIONS:
        assert type_of(kind).deserialize(new(kind).serialize(use_version_2=False)) == new(kind)


def test_the_bytes_are_those_of_an_independent_library():
    pytest.importorskip("rosbags")
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_JAZZY)
    marker = new("visualization_msgs/msg/Marker", ns="goal", id=3, points=[new("geometry_msgs/msg/Point", x=1.5)])
    array = new("visualization_msgs/msg/MarkerArray", markers=[marker])
    data = array.serialize(use_version_2=False)
    read = store.deserialize_cdr(data, "visualization_msgs/msg/MarkerArray")
    assert read.markers[0].points[0].x == 1.5
    assert bytes(store.serialize_cdr(read, "visualization_msgs/msg/MarkerArray"))[4:] == data[4 : len(data)]
    grid = new("nav_msgs/msg/OccupancyGrid", data=[-1, 0, 100])
    told = store.deserialize_cdr(grid.serialize(use_version_2=False), "nav_msgs/msg/OccupancyGrid")
    assert told.data.tolist() == [-1, 0, 100]


def test_what_cannot_be_is_refused_in_a_line(capsys, monkeypatch):
    for words, said in {
        "robot --robots a,b --name a": "expected --area X0,Y0,X1,Y1 for a team",
        "robot --area 1,2,3": "expected X0,Y0,X1,Y1 in metres",
        "robot --policy reference": "given the map",
        "robot --goals service": "invalid choice",
    }.items():
        assert main(words.split()) == 2
        error = capsys.readouterr().err
        assert said in error
        assert error.count("\n") == 1
    monkeypatch.setenv("ROS_DOMAIN_ID", "many")
    assert main(["robot"]) == 2
    assert "expected ROS_DOMAIN_ID from 0 to 232" in capsys.readouterr().err


def test_a_missing_library_is_told_in_a_line(capsys, monkeypatch):
    names = [name for name in sys.modules if name.startswith("cyclonedds") or ".robot.messages" in name]
    for name in (*names, "indoor_explorers.evaluation.robot.dds", "indoor_explorers.evaluation.robot.running"):
        monkeypatch.delitem(sys.modules, name, raising=False)
    for name in ("navigation", "simulated"):
        monkeypatch.delitem(sys.modules, f"indoor_explorers.evaluation.robot.{name}", raising=False)
    monkeypatch.setitem(sys.modules, "cyclonedds", None)
    for words in ("robot", "robot simulate"):
        assert main(words.split()) == 2
        error = capsys.readouterr().err
        assert '.[robot]"' in error
        assert error.count("\n") == 1

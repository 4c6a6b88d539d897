"""Bags of ROS 2 come back by topic, with the time of the header."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore
from whole import assert_refused, group_named, truncated, whole

from elastic_tendon.measurement.formats import open_source

STORE = get_typestore(Stores.ROS2_HUMBLE)
START = 1_700_000_000
COUNT = 50


def _type(name: str) -> Any:
    return STORE.types[name]


def _joint_state(i: int, names: list[str], start: int = START) -> Any:
    stamp = _type("builtin_interfaces/msg/Time")(start + i // 10, i % 10 * 100_000_000)
    header = _type("std_msgs/msg/Header")(stamp, "base")
    position = np.array([0.1 * i + k for k in range(len(names))])
    return _type("sensor_msgs/msg/JointState")(header, names, position, -position, np.array([]))


def _write(folder: Path, plugin: StoragePlugin, messages: list[tuple[str, str, int, Any]]) -> Path:
    with Writer(folder, version=9, storage_plugin=plugin) as bag:
        connections: dict[str, Any] = {}
        for topic, kind, time, message in messages:
            if topic not in connections:
                connections[topic] = bag.add_connection(topic, kind, typestore=STORE)
            bag.write(connections[topic], time, STORE.serialize_cdr(message, kind))
    return folder


def _messages() -> list[tuple[str, str, int, Any]]:
    found: list[tuple[str, str, int, Any]] = []
    kind = "sensor_msgs/msg/JointState"
    for i in range(COUNT):
        recorded = (START + 100) * 10**9 + i * 10**8
        found.append(("/joints", kind, recorded, _joint_state(i, ["elbow", "wrist"])))
        found.append(("/joints", kind, recorded, _joint_state(i, ["gripper"])))
        if i % 5 == 0:
            point = _type("geometry_msgs/msg/Point")(0.5 * i, 1.0, 2.0)
            quaternion = _type("geometry_msgs/msg/Quaternion")(0.0, 0.0, 0.0, 1.0)
            pose = _type("geometry_msgs/msg/Pose")(point, quaternion)
            found.append(("/pose", "geometry_msgs/msg/Pose", recorded, pose))
            text = _type("std_msgs/msg/String")("hello")
            found.append(("/chatter", "std_msgs/msg/String", recorded, text))
    return found


@pytest.fixture(params=[StoragePlugin.MCAP, StoragePlugin.SQLITE3], ids=["mcap", "sqlite"])
def bag(request, tmp_path: Path) -> Path:
    return _write(tmp_path / "bag", request.param, _messages())


def _file_of(bag: Path) -> Path:
    (path,) = (each for each in bag.iterdir() if each.suffix in (".mcap", ".db3"))
    return path


@pytest.mark.parametrize("of", ["folder", "file"])
def test_topics_are_groups_and_joints_have_names(bag: Path, of: str) -> None:
    source = open_source(bag if of == "folder" else _file_of(bag))
    assert {group.name for group in source.groups} == {"/joints", "/pose"}
    joints = group_named(source, "/joints")
    assert joints.units == {"time_s": "s"}
    assert {"time_s", "position[elbow]", "velocity[wrist]", "position[gripper]"} <= set(
        joints.columns
    )
    pose = whole(source, "/pose")
    assert np.array_equal(pose["position.x"], 2.5 * np.arange(10))
    assert np.allclose(np.diff(pose["time_s"]), 0.5, atol=1e-6)
    assert pose["time_s"][0] == START + 100.0


def test_messages_of_other_joints_are_left_out(bag: Path) -> None:
    source = open_source(bag)
    shares: list[float] = []
    columns = ["time_s", "position[elbow]", "velocity[wrist]"]
    (chunk,) = source.read("/joints", columns, lambda _text, share: shares.append(share))
    assert np.allclose(chunk["time_s"], START + 0.1 * np.arange(COUNT), rtol=0.0, atol=1e-6)
    assert np.array_equal(chunk["position[elbow]"], 0.1 * np.arange(COUNT))
    assert np.array_equal(chunk["velocity[wrist]"], -(0.1 * np.arange(COUNT) + 1.0))
    assert shares == [1.0]


def test_a_header_that_nobody_stamped_gives_way_to_the_recording(tmp_path: Path) -> None:
    kind = "sensor_msgs/msg/JointState"
    messages = [("/joints", kind, 10**9 * i, _joint_state(0, ["elbow"], 0)) for i in range(5)]
    source = open_source(_write(tmp_path / "bag", StoragePlugin.MCAP, messages))
    assert whole(source, "/joints")["time_s"].tolist() == [0.0, 1.0, 2.0, 3.0, 4.0]


def test_messages_are_sorted_by_their_stamps(tmp_path: Path) -> None:
    kind = "sensor_msgs/msg/JointState"
    order = [0, 2, 1, 3, 5, 4, 6]
    messages = [
        ("/joints", kind, 10**9 * place, _joint_state(i, ["elbow"]))
        for place, i in enumerate(order)
    ]
    source = open_source(_write(tmp_path / "bag", StoragePlugin.MCAP, messages))
    table = whole(source, "/joints")
    assert np.allclose(table["time_s"], START + 0.1 * np.arange(7), rtol=0.0, atol=1e-6)
    assert np.array_equal(table["position[elbow]"], 0.1 * np.arange(7))
    # whether or not the time is asked for
    (chunk,) = source.read("/joints", ["position[elbow]"], lambda _text, _share: None)
    assert np.array_equal(chunk["position[elbow]"], 0.1 * np.arange(7))


def test_brackets_with_joints_are_no_units(bag: Path) -> None:
    assert not any(group.bracketed_units for group in open_source(bag).groups)


@pytest.mark.parametrize("share", [0.1, 0.6])
def test_a_truncated_bag_is_refused(bag: Path, share: float) -> None:
    assert_refused(truncated(_file_of(bag), share), "ROS 2 bag is damaged or not complete")


def test_a_bag_with_another_suffix_is_named(bag: Path) -> None:
    renamed = _file_of(bag).rename(bag.parent / "run.csv")
    assert_refused(renamed, "this is a ROS 2 bag; rename it")


def test_messages_that_are_not_of_ros_2_are_named(tmp_path: Path) -> None:
    path = _file_of(_write(tmp_path / "bag", StoragePlugin.MCAP, _messages()))
    content = path.read_bytes()
    path.write_bytes(content.replace(b"\x03\x00\x00\x00cdr", b"\x03\x00\x00\x00abc"))
    assert_refused(path, "encoded as abc")


def test_a_folder_whose_bag_is_incomplete_is_refused(bag: Path) -> None:
    _file_of(bag).unlink()
    assert_refused(bag, "ROS 2 bag is damaged or not complete")
    (bag / "metadata.yaml").write_text("")
    assert_refused(bag, "ROS 2 bag is damaged or not complete")

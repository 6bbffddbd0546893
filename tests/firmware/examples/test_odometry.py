"""nav_msgs/Odometry, 720 bytes on the wire, from an Uno."""

from __future__ import annotations

import itertools
from pathlib import Path

import pytest

from firmware.examples.stage import running

SKETCH = """
#include <ros.h>
#include <nav_msgs/Odometry.h>

ros::NodeHandle nh;
nav_msgs::Odometry odom;
ros::Publisher pub("odom", &odom);

void setup() {
  nh.initNode();
  nh.advertise(pub);
  odom.header.frame_id = "odom";
  odom.child_frame_id = "base_link";
  for (int i = 0; i < 36; i++) odom.pose.covariance[i] = i * 0.125;
  odom.twist.covariance[35] = -1e-3;
}

void loop() {
  odom.header.stamp = nh.now();
  odom.pose.pose.position.x += 0.5;
  pub.publish(&odom);
  nh.spinOnce();
  delay(50);
}
"""


async def test_an_uno_publishes_odometry(tmp_path: Path) -> None:
    sketch = tmp_path / "Whole" / "Whole.ino"
    sketch.parent.mkdir()
    sketch.write_text(SKETCH)
    async with running(sketch) as stage:
        odom = await stage.listen("/odom", "nav_msgs/Odometry")
        messages = await odom.next_messages(5)
        for message, after in itertools.pairwise(messages):
            assert after.pose.pose.position.x == message.pose.pose.position.x + 0.5
        last = messages[-1]
        assert list(last.pose.covariance) == [i * 0.125 for i in range(36)]
        assert last.twist.covariance[35] == pytest.approx(-1e-3)
        assert (last.header.frame_id, last.child_frame_id) == ("odom", "base_link")
        assert await stage.board.free_stack_bytes() > 400

"""Programs in the style of the established libraries for Linux and Windows compile and run unchanged."""

from __future__ import annotations

from pathlib import Path

import pytest

from firmware.platforms.node_harness import node_harness
from firmware.platforms.programs import compile_program, running

# Its host is a text constant, which the library must not change. It reads the line once a second.
LINUX = """
#include <ros.h>
#include <std_msgs/Int32.h>
#include <std_msgs/UInt32.h>
#include <stdio.h>

ros::NodeHandle  nh;
std_msgs::UInt32 count;
ros::Publisher sonar1("count", &count);
char *rosSrvrIp = HOST;

void messageCb(const std_msgs::Int32& motor13_msg){
    int speed = motor13_msg.data;
    printf("Received subscribed motor speed %d\\n", speed);
}
ros::Subscriber<std_msgs::Int32> sub("motor13", messageCb );

int main()
{
    //nh.initNode();
    nh.initNode(rosSrvrIp);
    nh.advertise(sonar1);
    nh.subscribe(sub);
    while(1) {
          sleep(1);
          count.data++;
          sonar1.publish( &count );
          nh.spinOnce();
    }
}
"""
WINDOWS = """
#include <tchar.h>
#include <string>
#include <stdio.h>
#include "ros.h"
#include <std_msgs/String.h>
#include <windows.h>

using std::string;

void said_callback (const std_msgs::String & said)
{
  printf ("Received %s\\n", said.data);
}

int _tmain (int, _TCHAR **)
{
  ros::NodeHandle nh;
  char *ros_master = "1.2.3.4";
  printf ("Connecting to server at %s\\n", ros_master);
  nh.initNode (ros_master);
  ros::Subscriber < std_msgs::String > sub ("said", &said_callback);
  nh.subscribe (sub);
  while (1)
  {
    nh.spinOnce ();
    Sleep (100);
  }
}
"""


@pytest.mark.gcc
async def test_linux(library: Path, tmp_path: Path) -> None:
    source = tmp_path / "sonar.cpp"
    source.write_text(LINUX)
    async with node_harness() as harness, harness.bridge("tcp://127.0.0.1:0") as (address,):
        host = f'-DHOST="{address.removeprefix("tcp://")}"'
        command = ["g++", "-O1", "-Wno-write-strings", host]
        program = compile_program(command, [source], library, tmp_path / "sonar")
        async with running(program):
            await harness.wait_for_counts(1)


@pytest.mark.mingw
def test_windows(library: Path, tmp_path: Path) -> None:
    source = tmp_path / "receive.cpp"
    source.write_text(WINDOWS)
    command = ["x86_64-w64-mingw32-g++", "-O1", "-Wno-write-strings"]
    assert compile_program(command, [source], library, tmp_path / "receive.exe", "-lws2_32").is_file()

"""Publishes at 100 Hz, returns texts, and reports its free memory every 50 messages."""

import gc

import ros
from ros.ticks import ticks_diff, ticks_ms
from std_msgs.msg import Header, String, UInt32

PERIOD_MS = 10

nh = ros.NodeHandle()
stamps = ros.Publisher("stamps", Header)
memory = ros.Publisher("memory", UInt32)
texts = ros.Publisher("texts_out", String)
nh.initNode()
nh.advertise(stamps)
nh.advertise(memory)
nh.advertise(texts)
nh.subscribe(ros.Subscriber("texts_in", String, texts.publish))

header = Header(frame_id="board")
due_ms = ticks_ms()
while True:
    nh.spinOnce()
    if ticks_diff(ticks_ms(), due_ms) < 0:
        ros.ticks.sleep_ms(1)
        continue
    due_ms += PERIOD_MS
    header.stamp = nh.now()
    if stamps.publish(header) > 0:
        header.seq += 1
        if header.seq % 50 == 0:
            gc.collect()
            memory.publish(UInt32(gc.mem_free()))

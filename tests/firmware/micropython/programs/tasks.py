"""A node with asyncio: calls the service trigger repeatedly while it spins."""

import asyncio

import ros
from ros.tasks import call, spin
from std_msgs.msg import String
from std_srvs.srv import Trigger

nh = ros.NodeHandle()
answers = ros.Publisher("answer", String)
trigger = ros.ServiceClient("trigger", Trigger)
nh.initNode()
nh.advertise(answers)
nh.serviceClient(trigger)


async def main():
    spinning = asyncio.create_task(spin(nh))
    while not spinning.done():
        response = await call(trigger, Trigger.Request())
        if response:
            answers.publish(String(response.message))
        await asyncio.sleep(0.01)


asyncio.run(main())

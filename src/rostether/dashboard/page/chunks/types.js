var s=["sensor_msgs/CompressedImage","sensor_msgs/Image"];export{s as a};

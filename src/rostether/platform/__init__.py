"""The sensing platform: command and sensors of several robots, compatible with the nodes of its reference."""

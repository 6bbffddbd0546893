"""The sensing platform: commands and sensors of several robots, compatible with the reference platform."""

// The message types that are images.
export const IMAGE_TYPES: readonly string[] = ["sensor_msgs/CompressedImage", "sensor_msgs/Image"];

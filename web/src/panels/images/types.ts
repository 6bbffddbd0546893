// The message types that are pictures.
export const IMAGE_TYPES: readonly string[] = ["sensor_msgs/CompressedImage", "sensor_msgs/Image"];

// Pictures of the camera as sensor_msgs/CompressedImage with JPEG.
import { pageTimeMs } from "./clock_offset.ts";
import { type Problem, rateLimiter, type Sensor, SensorError } from "./sensor.ts";

const QUALITY = 0.7;
// Twice the fastest rate that can be chosen.
const POLL_MS = 16;
const PROBLEMS: Record<string, Problem> = {
  NotAllowedError: "denied",
  NotFoundError: "missing",
  OverconstrainedError: "missing",
  NotReadableError: "busy",
};

export const camera: Sensor = {
  id: "camera",
  type: "sensor_msgs/CompressedImage",
  topic: "camera/compressed",
  async start(output) {
    const { width, height, hertz, isFront } = output.settings;
    // Browsers do not offer cameras to pages without encryption.
    if (!navigator.mediaDevices) throw new SensorError("insecure");
    let stream: MediaStream;
    try {
      stream = await navigator.mediaDevices.getUserMedia({
        video: {
          width: { ideal: width },
          height: { ideal: height },
          facingMode: { ideal: isFront ? "user" : "environment" },
        },
      });
    } catch (error) {
      const { name, message } = error as DOMException;
      throw new SensorError(PROBLEMS[name] ?? { text: message });
    }
    const video = document.createElement("video");
    video.muted = true;
    video.playsInline = true;
    video.srcObject = stream;
    const canvas = document.createElement("canvas");
    const passes = rateLimiter(hertz);
    let isEncoding = false;
    let lastS = -1;
    const grab = () => {
      // One at a time: on a slow phone or network, fewer pictures are sent instead of old ones.
      if (isEncoding || video.videoWidth === 0 || video.currentTime === lastS || !output.hasRoom()) return;
      if (!passes(performance.now())) return;
      lastS = video.currentTime;
      const measuredMs = pageTimeMs();
      // The camera may not offer the chosen size; its proportions are kept.
      const scale = Math.min(1, width / video.videoWidth, height / video.videoHeight);
      canvas.width = Math.round(video.videoWidth * scale);
      canvas.height = Math.round(video.videoHeight * scale);
      canvas.getContext("2d")!.drawImage(video, 0, 0, canvas.width, canvas.height);
      isEncoding = true;
      canvas.toBlob(
        async (blob) => {
          const data = blob && new Uint8Array(await blob.arrayBuffer());
          isEncoding = false;
          if (data) output.publish({ format: "jpeg", data }, measuredMs);
        },
        "image/jpeg",
        QUALITY,
      );
    };
    const timer = setInterval(grab, POLL_MS);
    for (const track of stream.getTracks()) track.onended = () => output.fail("busy");
    const end = () => {
      clearInterval(timer);
      for (const track of stream.getTracks()) {
        track.onended = null;
        track.stop();
      }
      video.srcObject = null;
    };
    try {
      await video.play();
    } catch (error) {
      end();
      throw new SensorError({ text: String(error) });
    }
    return end;
  },
};

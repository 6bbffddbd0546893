// Prints what stands beside: proof that the packages can be imported.
import foxglove from "@foxglove/ws-protocol";
import roslib1 from "roslib1";
import * as roslib2 from "roslib2";
import WebSocket from "ws";

console.log(
  JSON.stringify({
    foxglove: foxglove.FoxgloveClient.SUPPORTED_SUBPROTOCOL,
    roslib1: roslib1.REVISION,
    roslib2: typeof roslib2.Ros,
    ws: typeof WebSocket,
  }),
);

// A web page's program on roslib: node roslib_client.mjs (1|2) URL PARAMETER
// It runs its checks one after another and prints, for each, {"check": name, "found": value} or "error".
import WebSocket from "ws";

const [generation, url, parameterName] = process.argv.slice(2);
const imported = await import(generation === "1" ? "roslib1" : "roslib2");
const ROSLIB = generation === "1" ? imported.default : imported;
globalThis.WebSocket ??= WebSocket;

const LIMIT_MS = 30000;

function settle(start, what) {
  return new Promise((resolve, reject) => {
    const timer = setTimeout(() => reject(new Error(`nothing came: ${what}`)), LIMIT_MS);
    const settled = (act) => (value) => {
      clearTimeout(timer);
      act(value);
    };
    start(settled(resolve), settled((reason) => reject(new Error(String(reason?.message ?? reason)))));
  });
}

const ros = new ROSLIB.Ros({ url });
await settle((resolve, reject) => {
  ros.on("connection", resolve);
  ros.on("error", reject);
}, "connection");
ros.on("error", () => {});

function topic(name, messageType, more = {}) {
  return new ROSLIB.Topic({ ros, name, messageType, ...more });
}

// roslib hands messages over by their topic alone: one that was on its way to the subscription before, in
// that one's compression, still reaches the next. `isAsked` tells them apart.
function first(name, messageType, more = {}, isAsked = () => true) {
  const subscribed = topic(name, messageType, more);
  return settle((resolve) => {
    subscribed.subscribe((message) => {
      if (!isAsked(message)) return;
      subscribed.unsubscribe();
      resolve(message);
    });
  }, name);
}

function call(name, serviceType, request) {
  const service = new ROSLIB.Service({ ros, name, serviceType });
  return settle((resolve, reject) => service.callService(request, resolve, reject), name);
}

function ask(method, ...values) {
  return settle((resolve, reject) => ros[method](...values, resolve, reject), method);
}

function kind(value) {
  return Object.prototype.toString.call(value).slice(8, -1);
}

const pause = (ms) => new Promise((resolve) => setTimeout(resolve, ms));

const checks = {
  latched: () => first("/latched", "std_msgs/String"),
  nested: () => first("/pose", "geometry_msgs/PoseStamped"),
  png: () => first("/pose", "geometry_msgs/PoseStamped", { compression: "png" }),
  cbor: () => first("/pose", "geometry_msgs/PoseStamped", { compression: "cbor" }),
  async cborRaw() {
    const { secs, bytes } = await first(
      "/pose",
      "geometry_msgs/PoseStamped",
      { compression: "cbor-raw" },
      (message) => "bytes" in message,
    );
    return { isNow: Math.abs(secs - Date.now() / 1000) < 100, bytes: Buffer.from(bytes).toString("hex") };
  },
  async scan() {
    const scan = await first("/scan", "sensor_msgs/LaserScan");
    return { length: scan.ranges.length, head: scan.ranges.slice(0, 3), max: scan.range_max };
  },
  async scanCbor() {
    const isTyped = (message) => !Array.isArray(message.ranges);
    const scan = await first("/scan", "sensor_msgs/LaserScan", { compression: "cbor" }, isTyped);
    return { kind: kind(scan.ranges), length: scan.ranges.length, last: scan.ranges[scan.ranges.length - 1] };
  },
  async image() {
    const image = await first("/image", "sensor_msgs/Image");
    const bytes = Buffer.from(image.data, "base64");
    return { length: bytes.length, head: [...bytes.subarray(0, 4)], frame: image.header.frame_id };
  },
  async imageCbor() {
    const isBinary = (message) => typeof message.data !== "string";
    const image = await first("/image", "sensor_msgs/Image", { compression: "cbor" }, isBinary);
    return { kind: kind(image.data), length: image.data.length, head: [...image.data.slice(0, 4)] };
  },
  async throttled() {
    // 200 messages a second come without a throttle: four in a fiftieth of one.
    let count = 0;
    const began = Date.now();
    const fast = topic("/fast", "std_msgs/UInt32", { throttle_rate: 250, queue_length: 1 });
    await settle((resolve) => fast.subscribe(() => (count += 1) === 4 && resolve()), "four messages");
    fast.unsubscribe();
    return Date.now() - began > 300;
  },
  async published() {
    const twist = topic("/from_page", "geometry_msgs/Twist");
    twist.advertise();
    twist.publish({ linear: { x: 1.5, y: 0, z: 0 }, angular: { x: 0, y: 0, z: -0.5 } });
    const text = topic("/text_from_page", "std_msgs/String");
    text.publish({ data: "grüße \u{1f600}" });
    const bytes = topic("/bytes_from_page", "std_msgs/UInt8MultiArray");
    bytes.publish({ data: [1, 2, 255] });
    await pause(0);
    return true;
  },
  called: () => call("/enable", "std_srvs/SetBool", { data: true }),
  refused: () => call("/fail", "std_srvs/Trigger", {}).catch((error) => error.message),
  absent: () => call("/nobody", "std_srvs/Trigger", {}).catch((error) => error.message),
  async parameters() {
    const parameter = new ROSLIB.Param({ ros, name: parameterName });
    await settle((resolve, reject) => parameter.set([1.5, 2.5], resolve, reject), "set");
    const value = await settle((resolve, reject) => parameter.get(resolve, reject), "get");
    const names = await ask("getParams");
    await settle((resolve, reject) => parameter.delete(resolve, reject), "delete");
    return { value, isListed: names.some((name) => name.startsWith(parameterName)) };
  },
  async rosapi() {
    const topics = await ask("getTopics");
    const details = await ask("getMessageDetails", "geometry_msgs/Twist");
    return {
      poseType: topics.types[topics.topics.indexOf("/pose")],
      topicType: await ask("getTopicType", "/pose"),
      topicsForType: await ask("getTopicsForType", "geometry_msgs/PoseStamped"),
      nodes: (await ask("getNodes")).filter((name) => name !== "/rosout" && !name.startsWith("/_")),
      services: (await ask("getServices")).filter((name) => ["/enable", "/fail"].includes(name)),
      serviceType: await ask("getServiceType", "/enable"),
      servicesForType: await ask("getServicesForType", "std_srvs/SetBool"),
      request: (await ask("getServiceRequestDetails", "std_srvs/SetBool")).typedefs[0].fieldnames,
      response: (await ask("getServiceResponseDetails", "std_srvs/SetBool")).typedefs[0].fieldnames,
      decoded: ros.decodeTypeDefs(details),
      actionServers: await ask("getActionServers"),
      rawTypes: (await ask("getTopicsAndRawTypes")).typedefs_full_text.length === topics.topics.length,
    };
  },
  async nodeDetails() {
    const found = await settle(
      (resolve, reject) =>
        ros.getNodeDetails("/talker", (...answer) => resolve(answer), (error) => reject(error)),
      "getNodeDetails",
    );
    // The first generation hands the lists over one by one, the second in an object.
    return found.length === 3 ? found[1] : found[0].publishing;
  },
  async action() {
    const client = new ROSLIB.ActionClient({
      ros,
      serverName: "/lookup",
      actionName: "tf2_msgs/LookupTransformAction",
    });
    const goal = new ROSLIB.Goal({
      actionClient: client,
      goalMessage: { target_frame: "base", source_frame: "tool" },
    });
    const result = await settle((resolve) => {
      goal.on("result", resolve);
      goal.send();
    }, "result of the action");
    client.dispose();
    return result.error.error_string;
  },
  // An action of ROS 2, offered by this page and called by it.
  async ros2Action() {
    if (!ROSLIB.Action || !parameterName.includes(":")) return null;
    const name = "/from_page/count";
    const actionType = "example_interfaces/action/Fibonacci";
    const server = new ROSLIB.Action({ ros, name, actionType });
    server.advertise(
      ({ order }, id) => {
        server.sendFeedback(id, { sequence: [order] });
        // A goal of 9 goes on until it is canceled.
        if (order !== 9) server.setSucceeded(id, { sequence: [order, order] });
      },
      (id) => server.setCanceled(id, { sequence: [] }),
    );
    const client = new ROSLIB.Action({ ros, name, actionType });
    const run = (order, onFeedback) =>
      settle((resolve) => {
        let feedback = null;
        const id = client.sendGoal(
          { order },
          (result) => resolve({ feedback, result }),
          (found) => {
            feedback = found;
            onFeedback?.(id);
          },
          (error) => resolve({ feedback, error }),
        );
      }, "result of a ROS 2 action");
    const found = [await run(3), await run(9, (id) => client.cancelGoal(id))];
    server.unadvertise();
    return found;
  },
  async served() {
    const service = new ROSLIB.Service({ ros, name: "/from_page/double", serviceType: "std_srvs/SetBool" });
    service.advertise((request, response) => {
      response.success = !request.data;
      response.message = `page got ${request.data}`;
      return true;
    });
    console.log(JSON.stringify({ check: "serving" }));
    await settle((resolve) => process.stdin.once("data", resolve), "a word to go on");
    service.unadvertise();
    return true;
  },
  async reconnected() {
    const again = topic("/latched", "std_msgs/String", { reconnect_on_close: true });
    let resolveNext = () => {};
    again.subscribe((message) => resolveNext(message));
    const closed = settle((resolve) => ros.on("close", resolve), "close");
    console.log(JSON.stringify({ check: "waiting for close" }));
    await closed;
    const message = settle((resolve) => (resolveNext = resolve), "a message after the reconnection");
    for (let attempt = 0; attempt < 100 && !ros.isConnected; attempt += 1) {
      try {
        await ros.connect(url);
      } catch {
        // Not there yet.
      }
      await pause(100);
    }
    return message;
  },
};

for (const [check, run] of Object.entries(checks)) {
  try {
    console.log(JSON.stringify({ check, found: await run() }));
  } catch (error) {
    console.log(JSON.stringify({ check, error: String(error?.stack ?? error) }));
  }
}
ros.close();
process.exit(0);

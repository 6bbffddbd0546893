// The movable joints of a URDF with their limits, as joint_state_publisher_gui shows them.

export interface Joint {
  readonly name: string;
  readonly isRevolute: boolean;
  readonly lower: number;
  readonly upper: number;
}

/** Reads the joints that can be set: not fixed, floating or mimicking. An unreadable URDF has none. */
export function readJoints(urdf: string): Joint[] {
  const document = new DOMParser().parseFromString(urdf, "text/xml");
  const joints: Joint[] = [];
  for (const element of document.querySelectorAll("robot > joint")) {
    const type = element.getAttribute("type") ?? "";
    const name = element.getAttribute("name") ?? "";
    if (name === "" || !["revolute", "continuous", "prismatic"].includes(type)) continue;
    if (element.querySelector(":scope > mimic") !== null) continue;
    const limit = element.querySelector(":scope > limit");
    const read = (key: string, otherwise: number) => {
      const value = Number.parseFloat(limit?.getAttribute(key) ?? "");
      return Number.isFinite(value) ? value : otherwise;
    };
    const isEndless = type === "continuous";
    joints.push({
      name,
      isRevolute: type !== "prismatic",
      lower: isEndless ? -Math.PI : read("lower", 0),
      upper: isEndless ? Math.PI : read("upper", 0),
    });
  }
  return joints;
}

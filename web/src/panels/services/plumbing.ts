// Services of nodes that are for tools.
import type { Service } from "../../connection/protocol.ts";

const TYPES =
  /^(roscpp|rosapi|rosapi_msgs|rcl_interfaces|type_description_interfaces|dynamic_reconfigure|lifecycle_msgs|diagnostic_msgs|tf2_msgs|nodelet)\//;

export function isPlumbing(service: Pick<Service, "name" | "type">): boolean {
  return TYPES.test(service.type) || /\/(get_loggers|set_logger_level)$/.test(service.name);
}

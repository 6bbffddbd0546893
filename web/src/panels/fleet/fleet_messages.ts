// The messages and services of a fleet.
export const FLEET_TYPE = "sensing_platform/Fleet";
export const STOP_TYPE = "sensing_platform/StopRobots";

/** sensing_platform/RobotState. */
export interface RobotState {
  id: number;
  address: string;
  state: string;
  commanded_by: string;
  loss: number;
  signal_dbm: number;
  uses_unicast: boolean;
  answered: { sec: number; nsec: number };
}

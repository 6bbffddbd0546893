// The extent of a display's content, for a camera that shows all of it.
import {
  type Box3,
  type BufferGeometry,
  InstancedMesh,
  Matrix4,
  type Object3D,
  Sprite,
  Vector3,
} from "three";

/** How many points of an object are measured: enough to find its extent. */
const MAX_POINTS = 1000;
/** A few wrong points far away must not make the rest a dot. */
const MAX_DISTANCE_M = 200;

/** Expands a box by the points that an object draws, in the frame of the whole picture. */
export function expandByContent(box: Box3, root: Object3D): void {
  root.updateWorldMatrix(true, true);
  const point = new Vector3();
  const add = () => {
    // False for NaN too.
    if (point.length() <= MAX_DISTANCE_M) box.expandByPoint(point);
  };
  root.traverseVisible((object) => {
    const { geometry } = object as { geometry?: BufferGeometry };
    if (geometry === undefined || object instanceof Sprite || object.userData.isOutOfView) return;
    if (object instanceof InstancedMesh) {
      const pose = new Matrix4();
      for (let i = 0; i < object.count; i += stepOf(object.count)) {
        object.getMatrixAt(i, pose);
        point.setFromMatrixPosition(pose).applyMatrix4(object.matrixWorld);
        add();
      }
      return;
    }
    const positions = geometry.getAttribute("position");
    if (positions === undefined) return;
    // A buffer may be larger than its drawn part.
    const count = Math.min(geometry.drawRange.count, positions.count);
    for (let i = 0; i < count; i += stepOf(count)) {
      point.fromBufferAttribute(positions, i).applyMatrix4(object.matrixWorld);
      add();
    }
  });
}

function stepOf(count: number): number {
  return Math.ceil(count / MAX_POINTS);
}

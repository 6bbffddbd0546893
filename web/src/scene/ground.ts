// The ground: a grid at z = 0 that fades out around its middle.
import { BufferAttribute, BufferGeometry, type Color, LineBasicMaterial, LineSegments } from "three";

/** Cells from the middle to the edge. */
const REACH = 20;
/** Cells along the longest side of the robot. */
const CELLS_PER_ROBOT = 5;

/** The side of a cell for a robot of this size: 1, 2 or 5 times a power of ten meters. */
export function cellFor(sizeM: number): number {
  const wanted = sizeM / CELLS_PER_ROBOT;
  const power = 10 ** Math.floor(Math.log10(wanted));
  const factor = [5, 2].find((each) => each * power <= wanted) ?? 1;
  return Number((factor * power).toPrecision(1));
}

export class Ground {
  readonly lines = new LineSegments(
    new BufferGeometry(),
    new LineBasicMaterial({ vertexColors: true, transparent: true, depthWrite: false }),
  );

  constructor() {
    // A piece for each side of a cell, because software renderers omit lines that reach behind the camera.
    const ends: number[] = [];
    for (let line = -REACH; line <= REACH; line++)
      for (let cell = -REACH; cell < REACH; cell++)
        ends.push(line, cell, 0, line, cell + 1, 0, cell, line, 0, cell + 1, line, 0);
    this.lines.geometry.setAttribute("position", new BufferAttribute(new Float32Array(ends), 3));
    this.lines.renderOrder = -1;
  }

  setColor({ r, g, b }: Color): void {
    const { array, count } = this.lines.geometry.getAttribute("position");
    const colors = new Float32Array(count * 4);
    for (let i = 0; i < count; i++) {
      const part = Math.hypot(array[i * 3] as number, array[i * 3 + 1] as number) / REACH;
      colors.set([r, g, b, Math.max(0, 1 - part)], i * 4);
    }
    this.lines.geometry.setAttribute("color", new BufferAttribute(colors, 4));
  }

  /** Lays the grid around a point; its lines stay at multiples of the cell. */
  lay(cellM: number, x: number, y: number): void {
    this.lines.scale.setScalar(cellM);
    this.lines.position.set(Math.round(x / cellM) * cellM, Math.round(y / cellM) * cellM, 0);
  }

  dispose(): void {
    this.lines.geometry.dispose();
    this.lines.material.dispose();
  }
}

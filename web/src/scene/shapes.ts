// Shapes that several displays use. ROS axes: x forward, y left, z up.
import {
  BufferAttribute,
  BufferGeometry,
  CanvasTexture,
  ConeGeometry,
  CylinderGeometry,
  Group,
  LinearFilter,
  LineBasicMaterial,
  LineSegments,
  Mesh,
  MeshLambertMaterial,
  Sprite,
  SpriteMaterial,
  SRGBColorSpace,
} from "three";

/** The three axes of a frame: red x, green y, blue z. */
export function axes(lengthM: number): LineSegments {
  const l = lengthM;
  const geometry = new BufferGeometry();
  const ends = new Float32Array([0, 0, 0, l, 0, 0, 0, 0, 0, 0, l, 0, 0, 0, 0, 0, 0, l]);
  const [r, g, b] = [
    [0.92, 0.26, 0.24],
    [0.25, 0.7, 0.31],
    [0.25, 0.47, 0.95],
  ];
  const colors = new Float32Array([r, r, g, g, b, b].flat() as number[]);
  geometry.setAttribute("position", new BufferAttribute(ends, 3));
  geometry.setAttribute("color", new BufferAttribute(colors, 3));
  return new LineSegments(geometry, new LineBasicMaterial({ vertexColors: true }));
}

/** An arrow along x from the origin. */
export function arrow(lengthM: number, color: string, shaftM = lengthM * 0.06): Group {
  const group = new Group();
  const headM = Math.min(lengthM * 0.3, shaftM * 5);
  const material = new MeshLambertMaterial({ color });
  const shaft = new Mesh(new CylinderGeometry(shaftM, shaftM, lengthM - headM, 12), material);
  shaft.rotation.z = -Math.PI / 2;
  shaft.position.x = (lengthM - headM) / 2;
  const head = new Mesh(new ConeGeometry(shaftM * 2.2, headM, 16), material);
  head.rotation.z = -Math.PI / 2;
  head.position.x = lengthM - headM / 2;
  group.add(shaft, head);
  return group;
}

/** Text that always faces the viewer. `heightM` is the height of its line. */
export function label(text: string, heightM: number, color: string): Sprite {
  const map = textTexture(text, 48, color);
  const sprite = new Sprite(new SpriteMaterial({ map, depthTest: false }));
  const { width, height } = map.image as HTMLCanvasElement;
  sprite.scale.set((heightM * width) / height, heightM, 1);
  sprite.renderOrder = 10;
  return sprite;
}

/** A texture with text; `lineHeightPx` is its height, `halo` the color around its letters. */
export function textTexture(text: string, lineHeightPx: number, color: string, halo?: string): CanvasTexture {
  const canvas = document.createElement("canvas");
  const font = `${lineHeightPx * 0.7}px system-ui, sans-serif`;
  const context = canvas.getContext("2d") as CanvasRenderingContext2D;
  context.font = font;
  canvas.width = Math.ceil(context.measureText(text.slice(0, 200)).width) + 8;
  canvas.height = lineHeightPx;
  context.font = font;
  context.fillStyle = color;
  context.textBaseline = "middle";
  if (halo !== undefined) {
    context.strokeStyle = halo;
    context.lineJoin = "round";
    context.lineWidth = 6;
    context.strokeText(text.slice(0, 200), 4, lineHeightPx / 2);
  }
  context.fillText(text.slice(0, 200), 4, lineHeightPx / 2);
  const texture = new CanvasTexture(canvas);
  texture.colorSpace = SRGBColorSpace;
  texture.generateMipmaps = false;
  texture.minFilter = LinearFilter;
  return texture;
}

/** Makes room for `count` points, which are drawn; returns their positions and colors, to fill in. */
export function resizePoints(geometry: BufferGeometry, count: number): [Float32Array, Float32Array] {
  const have = geometry.getAttribute("position") as BufferAttribute | undefined;
  if (have === undefined || have.count < count) {
    const room = Math.ceil(count * 1.25);
    geometry.setAttribute("position", new BufferAttribute(new Float32Array(room * 3), 3));
    geometry.setAttribute("color", new BufferAttribute(new Float32Array(room * 3), 3));
  }
  geometry.setDrawRange(0, count);
  const position = geometry.getAttribute("position") as BufferAttribute;
  const color = geometry.getAttribute("color") as BufferAttribute;
  position.needsUpdate = true;
  color.needsUpdate = true;
  return [position.array as Float32Array, color.array as Float32Array];
}

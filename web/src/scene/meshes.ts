// Mesh files of robot descriptions and markers: STL, Collada and OBJ, fetched through the gateway.
import { type Material, Mesh, MeshLambertMaterial, type Object3D } from "three";
import { ColladaLoader } from "three/examples/jsm/loaders/ColladaLoader.js";
import { OBJLoader } from "three/examples/jsm/loaders/OBJLoader.js";
import { STLLoader } from "three/examples/jsm/loaders/STLLoader.js";
import { checkCollada, checkStl } from "./mesh_limits.ts";

type FetchAsset = (uri: string) => Promise<Uint8Array>;

/**
 * Loads a mesh.
 *
 * @param uri package:// or file://
 * @param material replaces the file's own; undefined keeps the file's.
 * @throws Error with a sentence for the user.
 */
export async function loadMesh(uri: string, fetchAsset: FetchAsset, material?: Material): Promise<Object3D> {
  const bytes = await fetchAsset(uri);
  const kind = uri.slice(uri.lastIndexOf(".") + 1).toLowerCase();
  const object = parse(kind, uri, bytes);
  if (material !== undefined || kind === "stl")
    object.traverse((each) => {
      if (each instanceof Mesh) each.material = material ?? new MeshLambertMaterial({ color: "#b8bcc4" });
    });
  return object;
}

function parse(kind: string, uri: string, bytes: Uint8Array): Object3D {
  try {
    if (kind === "stl") {
      checkStl(bytes);
      const geometry = new STLLoader().parse(ownBuffer(bytes));
      // Many files have zeros for normals.
      geometry.computeVertexNormals();
      return new Mesh(geometry);
    }
    const text = new TextDecoder().decode(bytes);
    if (kind === "dae") {
      checkCollada(text);
      const scene = new ColladaLoader().parse(text, "")?.scene;
      if (scene === undefined) throw new Error("it has no scene");
      // In Collada files of robots, z points up as in ROS; the loader rotates them, because in three.js y points up.
      scene.rotation.set(0, 0, 0);
      return scene;
    }
    if (kind === "obj") return new OBJLoader().parse(text);
  } catch (error) {
    throw new Error(`${uri} is not a readable ${kind} file: ${(error as Error).message}`);
  }
  throw new Error(`${uri} is not drawn: meshes are STL, Collada (.dae) or OBJ files.`);
}

/** A buffer of only these bytes, because loaders read from the buffer's start. */
function ownBuffer(bytes: Uint8Array): ArrayBuffer {
  return bytes.slice().buffer as ArrayBuffer;
}

// A map with the robots' positions and tracks, on tiles from the robot or on a grid.
import L from "leaflet";
import { nearestLongitude, type Position, Track } from "./track.ts";

const COLORS = ["#4c9aff", "#f5a524", "#36b37e", "#e5618a", "#9a6cf5", "#2bb8c4"];
// The space between the robots and the edges of the map, in pixels.
const PADDING: L.PointTuple = [40, 40];

interface Robot {
  readonly track: Track;
  readonly line: L.Polyline;
  readonly dot: L.CircleMarker;
}

/** The edges of empty tiles as lines, if there are no tiles. */
const Grid = L.GridLayer.extend({
  createTile(this: L.GridLayer): HTMLElement {
    const tile = document.createElement("div");
    tile.className = "map-grid-tile";
    return tile;
  },
}) as unknown as new () => L.GridLayer;

export class MapView {
  private readonly map: L.Map;
  private readonly robots = new Map<string, Robot>();
  private readonly resizes: ResizeObserver;
  isFollowing = true;

  /**
   * @param tiles the address of tiles with {z}, {x} and {y}, and their largest zoom; undefined draws a grid.
   * @param onMoved called when the user moves the map, which ends following.
   */
  constructor(host: HTMLElement, tiles: { url: string; maxZoom: number } | undefined, onMoved: () => void) {
    this.map = L.map(host, { attributionControl: false, zoomControl: true, maxZoom: 22 });
    this.map.setView([0, 0], 2);
    L.control.scale({ imperial: false }).addTo(this.map);
    if (tiles === undefined) new Grid().addTo(this.map);
    else L.tileLayer(tiles.url, { maxNativeZoom: tiles.maxZoom, maxZoom: 22 }).addTo(this.map);
    this.map.on("dragstart", () => {
      this.isFollowing = false;
      onMoved();
    });
    this.resizes = new ResizeObserver(() => this.map.invalidateSize());
    this.resizes.observe(host);
  }

  /** Shows a robot at its new position. */
  move(name: string, position: Position): void {
    let robot = this.robots.get(name);
    const near = robot ?? this.robots.values().next().value;
    const longitude = nearestLongitude(position.longitude, near?.dot.getLatLng().lng ?? 0);
    const at: L.LatLngTuple = [position.latitude, longitude];
    if (robot === undefined) {
      const color = COLORS[this.robots.size % COLORS.length] as string;
      robot = {
        track: new Track(),
        line: L.polyline([], { color, weight: 3, opacity: 0.7 }).addTo(this.map),
        dot: L.circleMarker(at, { radius: 8, color: "#fff", weight: 2, fillColor: color, fillOpacity: 1 }),
      };
      robot.dot.bindTooltip(name, { permanent: true, direction: "right", offset: [10, 0] }).addTo(this.map);
      this.robots.set(name, robot);
      if (this.robots.size === 1) this.map.setView(at, 18);
    }
    robot.dot.setLatLng(at);
    const { track, line } = robot;
    if (track.add({ latitude: position.latitude, longitude })) {
      if (track.positions.length > line.getLatLngs().length) line.addLatLng(at);
      else line.setLatLngs(track.positions.map((each) => L.latLng(each.latitude, each.longitude)));
    }
    if (this.isFollowing) this.follow(at);
  }

  /** Keeps one robot in the middle, and several in the picture. */
  private follow(moved: L.LatLngTuple): void {
    if (this.robots.size === 1) this.map.panTo(moved, { animate: false });
    else if (!this.map.getBounds().contains(moved)) {
      const positions = [...this.robots.values()].map(({ dot }) => dot.getLatLng());
      const options = { padding: PADDING, maxZoom: this.map.getZoom(), animate: false };
      this.map.fitBounds(L.latLngBounds(positions), options);
    }
  }

  /** Shows all robots. */
  fit(): void {
    const bounds = L.latLngBounds([]);
    for (const { line, dot } of this.robots.values()) {
      bounds.extend(dot.getLatLng());
      if (line.getLatLngs().length > 0) bounds.extend(line.getBounds());
    }
    if (bounds.isValid()) this.map.fitBounds(bounds, { padding: PADDING, maxZoom: 19 });
  }

  dispose(): void {
    this.resizes.disconnect();
    this.map.remove();
  }
}

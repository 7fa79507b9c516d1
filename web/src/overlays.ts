// Lines over a facade: openings with their bars and errors, protrusions, measurements.

import type { Facade, Opening, Ortho, Point } from "./data";
import { pixelFromFacade } from "./measure";
import type { Viewport } from "./viewport";

export interface Shown { openings: boolean; bars: boolean; protrusions: boolean; errors: boolean }

const KIND_COLOURS: Record<string, string> = {
  window: "#1f6fd6", door: "#c2410c", shopfront: "#7c3aed", passage: "#b45309", garage: "#b45309", basement: "#0e7490",
};
export const kindColour = (kind: string): string => KIND_COLOURS[kind] ?? "#475569";

export class Overlays {
  constructor(private readonly context: CanvasRenderingContext2D, private readonly view: Viewport, private readonly ortho: Ortho) {}

  elements(facade: Facade, shown: Shown, selected: string | null, hovered: string | null): void {
    if (shown.protrusions) {
      for (const p of facade.protrusions) this.stroke(p.ring, "#0f766e", 1.25, [5, 4]);
    }
    for (const o of facade.openings ?? []) {
      if (shown.errors) this.errors(o);
      if (shown.bars) this.bars(o);
      if (shown.openings || o.id === selected || o.id === hovered) this.opening(o, o.id === selected, o.id === hovered);
    }
  }

  private opening(o: Opening, selected: boolean, hovered: boolean): void {
    const dash = o.provenance === "measured" ? [] : [6, 4];
    if (selected) this.fill(o.ring, `${kindColour(o.kind)}22`);
    this.stroke(o.ring, "#ffffffb0", selected ? 5 : 3);
    this.stroke(o.ring, kindColour(o.kind), selected ? 3 : hovered ? 2.5 : 1.5, dash);
  }

  private bars(o: Opening): void {
    const c = this.context;
    c.save();
    c.lineWidth = 1;
    c.strokeStyle = "#ffffff";
    c.fillStyle = `${kindColour(o.kind)}88`;
    for (const bar of o.bars) {
      const half = bar.width / 2;
      const [a, b] = bar.axis === "vertical"
        ? [[bar.position - half, bar.extent[1]], [bar.position + half, bar.extent[0]]]
        : [[bar.extent[0], bar.position + half], [bar.extent[1], bar.position - half]];
      const [x0, y0] = this.at(a as Point), [x1, y1] = this.at(b as Point);
      c.fillRect(x0, y0, x1 - x0, y1 - y0);
      c.strokeRect(x0, y0, x1 - x0, y1 - y0);
    }
    c.restore();
  }

  // Twice the standard error of every border, as a band to both sides.
  private errors(o: Opening): void {
    const { left, right, bottom, top } = o.sigma;
    const xs = o.ring.map((p) => p[0]), zs = o.ring.map((p) => p[1]);
    const [x0, x1, z0, z1] = [Math.min(...xs), Math.max(...xs), Math.min(...zs), Math.max(...zs)];
    const c = this.context;
    c.save();
    c.fillStyle = "#dc262666";
    const band = (a: Point, b: Point) => {
      const [u0, v0] = this.at(a), [u1, v1] = this.at(b);
      c.fillRect(u0, v0, u1 - u0, v1 - v0);
    };
    if (left) band([x0 - 2 * left, z1], [x0 + 2 * left, z0]);
    if (right) band([x1 - 2 * right, z1], [x1 + 2 * right, z0]);
    if (bottom) band([x0, z0 + 2 * bottom], [x1, z0 - 2 * bottom]);
    if (top) band([x0, z1 + 2 * top], [x1, z1 - 2 * top]);
    c.restore();
  }

  // A path or polygon of pixels that is being measured; `next` is where the pointer is.
  measurement(pixels: Point[], closed: boolean, next: Point | null): void {
    const points = [...pixels, ...(next ? [next] : [])].map((p) => this.view.toScreen(p));
    if (!points.length) return;
    const c = this.context;
    c.save();
    const trace = () => {
      c.beginPath();
      points.forEach(([x, y], k) => (k ? c.lineTo(x, y) : c.moveTo(x, y)));
      if (closed && points.length > 2) c.closePath();
    };
    trace();
    if (closed && points.length > 2) { c.fillStyle = "#f59e0b33"; c.fill(); }
    for (const [colour, width] of [["#000000aa", 4], ["#fbbf24", 2]] as const) {
      c.strokeStyle = colour;
      c.lineWidth = width;
      c.stroke();
    }
    for (const [x, y] of points.slice(0, pixels.length)) this.dot(x, y, "#fbbf24");
    c.restore();
  }

  mark(pixel: Point): void {
    const [x, y] = this.view.toScreen(pixel), c = this.context;
    c.save();
    for (const [colour, width] of [["#ffffff", 4], ["#dc2626", 1.75]] as const) {
      c.strokeStyle = colour;
      c.lineWidth = width;
      c.beginPath();
      for (const [dx, dy] of [[1, 0], [-1, 0], [0, 1], [0, -1]] as const) {
        c.moveTo(x + 3 * dx, y + 3 * dy);
        c.lineTo(x + 11 * dx, y + 11 * dy);
      }
      c.stroke();
    }
    c.restore();
  }

  outline(ring: Point[]): void {
    this.stroke(ring, "#ffffff99", 3);
    this.stroke(ring, "#334155", 1);
  }

  private dot(x: number, y: number, colour: string): void {
    const c = this.context;
    c.beginPath();
    c.arc(x, y, 4, 0, 2 * Math.PI);
    c.fillStyle = colour;
    c.fill();
    c.lineWidth = 1.5;
    c.strokeStyle = "#000000cc";
    c.stroke();
  }

  private stroke(ring: Point[], colour: string, width: number, dash: number[] = []): void {
    const c = this.context;
    c.save();
    c.setLineDash(dash);
    c.strokeStyle = colour;
    c.lineWidth = width;
    c.lineJoin = "round";
    this.trace(ring);
    c.stroke();
    c.restore();
  }

  private fill(ring: Point[], colour: string): void {
    this.context.fillStyle = colour;
    this.trace(ring);
    this.context.fill();
  }

  private trace(ring: Point[]): void {
    const c = this.context;
    c.beginPath();
    ring.forEach((p, k) => { const [x, y] = this.at(p); if (k) c.lineTo(x, y); else c.moveTo(x, y); });
    c.closePath();
  }

  private at(p: Point): Point {
    return this.view.toScreen(pixelFromFacade(this.ortho, p));
  }
}

// The canvas of a facade: picture, layer and lines, and what the pointer does on it.

import { Bands } from "./bands";
import type { BandName, Facade, FacadeEntry, Opening, Ortho, Picture, Point, Run } from "./data";
import { listen } from "./gestures";
import { facadeFromPixel, inside, pixelFromFacade, worldFromPixel, type WorldPoint } from "./measure";
import { Overlays, type Shown } from "./overlays";
import { Rasters } from "./rasters";
import { Viewport } from "./viewport";

export type Layer = "photo" | BandName | Picture;
export type Tool = "look" | "length" | "area";

export interface Probe {
  pixel: Point; world: WorldPoint; source: string | null; resolution: number | null; pinned: boolean;
}
export interface ViewEvents {
  probe(probe: Probe | null): void;
  measured(pixels: Point[], tool: Tool): void;
  picked(opening: Opening | null): void;
  problem(text: string): void;
}

export class FacadeView {
  readonly canvas = document.createElement("canvas");
  readonly view: Viewport;
  readonly bands: Bands;
  readonly rasters: Rasters;
  layer: Layer = "photo";
  opacity = 0.75;
  shown: Shown = { openings: true, bars: false, protrusions: false, errors: false };
  selected: string | null = null;
  private tool: Tool = "look";
  private path: Point[] = [];
  private pointer: Point | null = null;
  private pinned: Point | null = null;
  private hovered: string | null = null;
  private queued = false;
  private readonly pictures = new Map<string, HTMLImageElement>();
  private readonly observer = new ResizeObserver(() => this.resize());

  constructor(run: Run, entry: FacadeEntry, readonly facade: Facade, readonly ortho: Ortho, private readonly on: ViewEvents) {
    this.view = new Viewport([ortho.width, ortho.height]);
    this.bands = new Bands(run, entry);
    this.rasters = new Rasters(run, entry, this.bands, () => this.redraw());
    this.canvas.tabIndex = 0;
    this.canvas.setAttribute("aria-label", `Ortho-image of ${facade.id}`);
    this.canvas.setAttribute("role", "img");
    this.observer.observe(this.canvas);
    listen(this.canvas, {
      pan: (dx, dy) => { this.view.pan(dx, dy); this.redraw(); },
      zoom: (factor, at) => { this.view.zoom(factor, at); this.redraw(); },
      hover: (at) => this.hover(at),
      click: (at) => this.click(at),
      doubleClick: (at) => { if (this.tool === "look") { this.view.zoom(2, at); this.redraw(); } else this.finish(); },
    });
  }

  dispose(): void {
    this.observer.disconnect();
  }

  // Put the pin on a pixel, as a click does.
  pin(pixel: Point): void {
    this.pinned = pixel;
    this.tell();
    this.redraw();
  }

  setTool(tool: Tool): void {
    this.tool = tool;
    this.path = [];
    this.canvas.dataset["tool"] = tool;
    this.on.measured([], tool);
    this.redraw();
  }

  finish(): void {
    const last = this.path.length;
    // A double click has placed its point twice.
    if (last > 1 && Math.hypot(this.path[last - 1]![0] - this.path[last - 2]![0], this.path[last - 1]![1] - this.path[last - 2]![1]) * this.view.scale < 4)
      this.path.pop();
    this.pointer = null;
    this.done = true;
    this.on.measured(this.path, this.tool);
    this.redraw();
  }
  private done = false;

  // Leave what was begun: the points of a measurement, then the pin. Tells whether there was anything.
  cancel(): boolean {
    const had = this.path.length > 0 || this.pinned !== null;
    if (this.path.length) { this.path = []; this.on.measured([], this.tool); }
    else if (this.pinned) { this.pinned = null; this.on.probe(null); }
    this.redraw();
    return had;
  }

  flyTo(opening: Opening): void {
    const at = opening.ring.map((p) => pixelFromFacade(this.ortho, p));
    const cs = at.map((p) => p[0]), rs = at.map((p) => p[1]);
    this.resize();
    this.view.show([Math.min(...cs), Math.min(...rs)], [Math.max(...cs), Math.max(...rs)]);
    this.redraw();
  }

  redraw(): void {
    if (this.queued) return;
    this.queued = true;
    requestAnimationFrame(() => { this.queued = false; this.draw(); });
  }

  probeAt(pixel: Point, pinned = false): Probe | null {
    const [c, r] = pixel;
    if (c < 0 || r < 0 || c > this.ortho.width || r > this.ortho.height) return null;
    const again = () => this.tell();
    const depth = this.ortho.relief ? this.bands.at("depth", c, r, again) : null;
    if (depth === undefined) return null;
    const source = this.bands.at("sources", c, r, again);
    return {
      pixel, pinned, world: worldFromPixel(this.ortho, c, r, depth),
      source: source ? this.ortho.sources[source - 1] ?? null : null,
      resolution: this.bands.at("resolution", c, r, again) ?? null,
    };
  }

  private tell(): void {
    if (this.pinned) return this.on.probe(this.probeAt(this.pinned, true));
    if (this.pointer) this.on.probe(this.probeAt(this.view.toPicture(this.pointer)));
  }

  private hover(at: Point | null): void {
    this.pointer = at;
    const pixel = at && this.view.toPicture(at);
    const over = pixel && this.tool === "look" ? this.openingAt(pixel)?.id ?? null : null;
    const changed = over !== this.hovered || this.tool !== "look";
    this.hovered = over;
    if (!this.pinned) { if (at) this.tell(); else this.on.probe(null); }
    if (changed) this.redraw();
  }

  private click(at: Point): void {
    const pixel = this.view.toPicture(at);
    this.canvas.focus({ preventScroll: true });
    if (this.tool !== "look") {
      if (this.done) { this.path = []; this.done = false; }
      this.path.push(pixel);
      this.on.measured(this.path, this.tool);
      return this.redraw();
    }
    this.pinned = this.probeInside(pixel) ? pixel : null;
    this.on.picked(this.openingAt(pixel));
    if (this.pinned) this.tell(); else this.on.probe(null);
    this.redraw();
  }

  private probeInside([c, r]: Point): boolean {
    return c >= 0 && r >= 0 && c <= this.ortho.width && r <= this.ortho.height;
  }

  private openingAt(pixel: Point): Opening | null {
    const at = facadeFromPixel(this.ortho, pixel);
    return (this.facade.openings ?? []).find((o) => inside(at, o.ring)) ?? null;
  }

  private resize(): void {
    const density = window.devicePixelRatio || 1;
    const { clientWidth: w, clientHeight: h } = this.canvas;
    if (!w || !h) return;
    const [pw, ph] = [Math.round(w * density), Math.round(h * density)];
    if (this.canvas.width === pw && this.canvas.height === ph) return;
    [this.canvas.width, this.canvas.height] = [pw, ph];
    this.view.resize(w, h);
    this.redraw();
  }

  private draw(): void {
    const density = window.devicePixelRatio || 1;
    const c = this.canvas.getContext("2d")!;
    c.setTransform(density, 0, 0, density, 0, 0);
    c.clearRect(0, 0, ...this.view.screen);
    this.rasters.draw(c, this.view, "photo", density);
    if (this.layer !== "photo") {
      c.globalAlpha = this.opacity;
      if (typeof this.layer === "string") this.rasters.draw(c, this.view, this.layer, density);
      else this.drawPicture(c, this.layer);
      c.globalAlpha = 1;
    }
    const lines = new Overlays(c, this.view, this.ortho);
    lines.outline(this.facade.outline);
    lines.elements(this.facade, this.shown, this.selected, this.hovered);
    const next = this.tool !== "look" && !this.done && this.path.length && this.pointer ? this.view.toPicture(this.pointer) : null;
    lines.measurement(this.path, this.tool === "area", next);
    if (this.pinned) lines.mark(this.pinned);
    if (this.rasters.problem) this.on.problem(this.rasters.problem);
    this.canvas.dispatchEvent(new Event("drawn"));
  }

  private drawPicture(c: CanvasRenderingContext2D, picture: Picture): void {
    let image = this.pictures.get(picture.path);
    if (!image) {
      image = new Image();
      this.pictures.set(picture.path, image);
      image.onload = () => this.redraw();
      image.src = picture.path;
    }
    if (!image.naturalWidth) return;
    const [x0, z0, x1, z1] = picture.extent;
    const [u0, v0] = this.view.toScreen(pixelFromFacade(this.ortho, [x0, z1]));
    const [u1, v1] = this.view.toScreen(pixelFromFacade(this.ortho, [x1, z0]));
    c.imageSmoothingEnabled = false;
    c.drawImage(image, u0, v0, u1 - u0, v1 - v0);
  }
}

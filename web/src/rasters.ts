// Draws the picture of a facade and the layers over it, block by block at the level that the screen needs.

import type { Bands } from "./bands";
import { hue, ramp, type Rgb } from "./colours";
import type { BandName, FacadeEntry, Run } from "./data";
import type { Block } from "./decode";
import type { Viewport } from "./viewport";

type Drawable = HTMLImageElement | HTMLCanvasElement;
export type Range = [number, number];

const CACHED = 96; // blocks

export class Rasters {
  private readonly made = new Map<string, Drawable | null>();
  readonly ranges: Record<BandName, Range>;
  problem = "";

  constructor(
    private readonly run: Run, private readonly entry: FacadeEntry, readonly bands: Bands, private readonly redraw: () => void,
  ) {
    this.ranges = { depth: [-0.3, 0.3], resolution: [0, 0.02], sources: [0, 1] };
  }

  // Draw a raster; `name` is "photo" or a band.
  draw(context: CanvasRenderingContext2D, view: Viewport, name: "photo" | BandName, density: number): void {
    const levels = this.entry.ortho!.levels;
    const wanted = Math.min(Math.max(Math.floor(-Math.log2(view.scale * density) + 0.25), 0), levels - 1);
    context.imageSmoothingEnabled = view.scale * density < 2;
    context.imageSmoothingQuality = "high";
    // The coarsest level shows through until finer blocks are there.
    for (const level of new Set([levels - 1, wanted])) this.drawLevel(context, view, name, level);
  }

  private drawLevel(context: CanvasRenderingContext2D, view: Viewport, name: "photo" | BandName, level: number): void {
    const { width, height } = this.entry.ortho!;
    const size = this.run.blocks * 2 ** level;
    const [c0, r0] = view.toPicture([0, 0]), [c1, r1] = view.toPicture(view.screen);
    const span = (low: number, high: number, side: number): [number, number] =>
      [Math.max(Math.floor(low / size), 0), Math.min(Math.floor(high / size), Math.ceil(side / size) - 1)];
    const [i0, i1] = span(c0, c1, width), [j0, j1] = span(r0, r1, height);
    for (let j = j0; j <= j1; j++) {
      for (let i = i0; i <= i1; i++) {
        const block = this.block(name, level, i, j);
        if (!block) continue;
        const [x, y] = view.toScreen([i * size, j * size]);
        const w = Math.min(size, width - i * size) * view.scale, h = Math.min(size, height - j * size) * view.scale;
        context.drawImage(block, x, y, w, h);
      }
    }
  }

  private block(name: "photo" | BandName, level: number, column: number, row: number): Drawable | null {
    const key = `${name}_${level}_${column}_${row}`;
    const known = this.made.get(key);
    if (known !== undefined) return known;
    this.made.set(key, null);
    const keep = (drawable: Drawable) => {
      this.made.set(key, drawable);
      if (this.made.size > CACHED) this.made.delete(this.made.keys().next().value!);
      this.redraw();
    };
    if (name === "photo") {
      const image = new Image();
      image.src = `${this.entry.path}/${key}.jpg`;
      image.decode().then(() => keep(image), () => { this.problem = "The picture of this facade is missing."; this.redraw(); });
    } else {
      this.bands.load(name, level, column, row).then((block) => keep(this.painted(name, block)), (error: Error) => {
        this.problem = error.message;
        this.redraw();
      });
    }
    return null;
  }

  private painted(name: BandName, block: Block): HTMLCanvasElement {
    const about = this.run.bands[name];
    if (name !== "sources" && block.values.length) this.widen(name, block);
    const [low, high] = this.ranges[name];
    const canvas = document.createElement("canvas");
    [canvas.width, canvas.height] = [block.width, block.height];
    const context = canvas.getContext("2d")!;
    const image = context.createImageData(block.width, block.height);
    const table = new Map<number, Rgb>();
    for (let k = 0; k < block.values.length; k++) {
      const value = block.values[k]!;
      if (value === about.missing || (name === "sources" && value === 0)) continue;
      let colour = table.get(value);
      if (!colour) {
        colour = name === "sources" ? hue(value - 1) : ramp((value * about.unit - low) / (high - low));
        table.set(value, colour);
      }
      image.data.set([colour[0], colour[1], colour[2], 255], 4 * k);
    }
    context.putImageData(image, 0, 0);
    return canvas;
  }

  // The colours span what most pixels of the first block hold; later blocks keep them.
  private readonly settled = new Set<BandName>();
  private widen(name: BandName, block: Block): void {
    if (this.settled.has(name)) return;
    const about = this.run.bands[name], step = Math.max(1, Math.floor(block.values.length / 20000));
    const known: number[] = [];
    for (let k = 0; k < block.values.length; k += step) {
      const v = block.values[k]!;
      if (v !== about.missing) known.push(v * about.unit);
    }
    if (known.length < 20) return;
    known.sort((a, b) => a - b);
    const low = known[Math.floor(0.02 * known.length)]!, high = known[Math.floor(0.98 * known.length)]!;
    this.ranges[name] = high > low ? [low, high] : [low - 0.001, low + 0.001];
    this.settled.add(name);
  }
}

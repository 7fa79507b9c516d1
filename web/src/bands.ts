// Bands of a facade (depth, sources, resolution) in blocks: fetched when needed, and looked up.

import type { BandName, FacadeEntry, Run } from "./data";
import { decode, type Block } from "./decode";

export class Bands {
  private readonly blocks = new Map<string, Promise<Block> | Block>();

  constructor(private readonly run: Run, private readonly entry: FacadeEntry) {}

  // Size of a block of a level, px; blocks at the right and lower edge are smaller.
  size(level: number, column: number, row: number): [number, number] {
    const ortho = this.entry.ortho!;
    const [w, h] = [ortho.width, ortho.height].map((side) => Math.ceil(side / 2 ** level)) as [number, number];
    const size = this.run.blocks;
    return [Math.min(size, w - column * size), Math.min(size, h - row * size)];
  }

  load(band: BandName, level: number, column: number, row: number): Promise<Block> {
    const key = `${band}_${level}_${column}_${row}`;
    const known = this.blocks.get(key);
    if (known) return Promise.resolve(known);
    const [width, height] = this.size(level, column, row);
    const made = fetch(`${this.entry.path}/${key}.bin`)
      .then((r) => (r.ok ? r.arrayBuffer() : r.text().then((why) => Promise.reject(new Error(why.trim())))))
      .then((data) => decode(data, this.run.bands[band], width, height));
    this.blocks.set(key, made);
    made.then((block) => this.blocks.set(key, block), () => this.blocks.delete(key));
    return made;
  }

  // The value of a pixel of level 0: in its unit, null where there is none, undefined while it is not loaded.
  at(band: BandName, column: number, row: number, loaded?: () => void): number | null | undefined {
    const ortho = this.entry.ortho!, size = this.run.blocks;
    const [c, r] = [Math.floor(column), Math.floor(row)];
    if (c < 0 || r < 0 || c >= ortho.width || r >= ortho.height) return null;
    const [i, j] = [Math.floor(c / size), Math.floor(r / size)];
    const block = this.blocks.get(`${band}_0_${i}_${j}`);
    if (block === undefined || block instanceof Promise) {
      void this.load(band, 0, i, j).then(() => loaded?.(), () => undefined);
      return undefined;
    }
    const value = block.values[(r - j * size) * block.width + (c - i * size)]!;
    const about = this.run.bands[band];
    return value === about.missing ? null : value * about.unit;
  }
}

// A block of a band from its bytes.

import type { BandAbout } from "./data";

export interface Block { values: Int32Array; width: number; height: number }

// The inverse of frontage.viewer.bands.encoded.
export async function decode(data: ArrayBuffer, about: BandAbout, width: number, height: number): Promise<Block> {
  const stream = new Blob([data]).stream().pipeThrough(new DecompressionStream("deflate"));
  const octets = new Uint8Array(await new Response(stream).arrayBuffer());
  const n = width * height;
  if (octets.length !== n * about.bytes) throw new Error("A band of the facade is damaged; export the run again.");
  const values = new Int32Array(n);
  for (let byte = 0; byte < about.bytes; byte++) {
    const shift = 8 * byte, start = n * byte;
    for (let k = 0; k < n; k++) values[k]! |= octets[start + k]! << shift;
  }
  const mask = about.bytes === 2 ? 0xffff : -1;
  for (let row = 0; row < height; row++) {
    let sum = 0;
    for (let k = row * width; k < (row + 1) * width; k++) values[k] = sum = (sum + values[k]!) & mask;
  }
  return { values, width, height };
}

// Colours of values: a perceptually even ramp for quantities, distinct hues for sources.

export type Rgb = [number, number, number];

// Cividis in nine steps: dark to light for everybody, colour-blind readers too.
const RAMP: Rgb[] = [[0, 34, 78], [18, 53, 112], [59, 73, 108], [87, 93, 109], [112, 113, 115],
  [138, 134, 120], [165, 156, 116], [195, 179, 105], [254, 232, 56]];

export function ramp(share: number): Rgb {
  const at = Math.min(Math.max(share, 0), 1) * (RAMP.length - 1);
  const k = Math.min(Math.floor(at), RAMP.length - 2), t = at - k;
  return RAMP[k]!.map((v, j) => v + t * (RAMP[k + 1]![j]! - v)) as Rgb;
}

export const rampCss = `linear-gradient(to right, ${RAMP.map((c) => `rgb(${c.join(" ")})`).join(", ")})`;

const HUES: Rgb[] = [[68, 119, 170], [238, 102, 119], [34, 136, 51], [204, 187, 68], [102, 204, 238], [170, 51, 119],
  [187, 187, 187], [221, 125, 45]];

export const hue = (index: number): Rgb => HUES[index % HUES.length]!;
export const css = (colour: Rgb): string => `rgb(${colour.map(Math.round).join(" ")})`;

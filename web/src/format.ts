// Numbers as people read them: the last digit that is shown is one that means something.

export const metres = (v: number, digits = 3): string => `${v.toFixed(digits)} m`;

export function plusMinus(sigma: number | null | undefined): string {
  if (sigma === null || sigma === undefined || !Number.isFinite(sigma)) return "";
  return ` ± ${millimetres(sigma)}`;
}

export function millimetres(v: number): string {
  const mm = v * 1000;
  return Math.abs(mm) < 9.95 ? `${mm.toFixed(1)} mm` : `${mm.toFixed(0)} mm`;
}

export const percent = (v: number): string => `${Math.round(v * 100)} %`;

export function counted(n: number, word: string): string {
  return `${n} ${word}${n === 1 ? "" : "s"}`;
}

// Finds buildings by id or address, by the rules of frontage.catalog.addresses, which the tests compare it with.

const SHORT: Record<string, string> = {
  avenue: "av", ave: "av", boulevard: "bd", blvd: "bd", place: "pl", square: "sq", road: "rd",
  lane: "ln", drive: "dr", court: "ct", street: "st", saint: "st", sankt: "st",
};
const NUMBER = /(?<![\p{L}\p{N}_])(\d{1,4})(?:\s*-?\s*(bis|ter|quater|[a-z]))?(?:\s*-\s*(\d{1,4})\s*([a-z])?)?(?=[\s,;./]|$)/gu;

interface Address { numbers: Set<string>; words: string[] }

export function parseAddress(text: string): Address {
  const plain = text.toLowerCase().replaceAll("ß", "ss").normalize("NFKD").replace(/\p{M}/gu, "").trim();
  const found = houseNumber(plain);
  const rest = found ? `${plain.slice(0, found.index)} ${plain.slice(found.index + found[0].length)}` : plain;
  const words = [...rest.matchAll(/[\p{L}\p{N}_]+/gu)].map((m) => short(m[0]));
  return { numbers: new Set(found ? numbers(found) : []), words };
}

// 3 = exactly, 2 = all that `asked` says is in `known`, 1 = the other way round, 0 = not at all.
export function match(asked: Address, known: Address): number {
  if (asked.numbers.size && ![...asked.numbers].some((n) => known.numbers.has(n))) return 0;
  if (asked.words.join("") === known.words.join("")) return asked.numbers.size || !known.numbers.size ? 3 : 2;
  const mine = new Set(asked.words), theirs = new Set(known.words);
  if (!mine.size || !theirs.size) return 0;
  if ([...mine].every((w) => theirs.has(w))) return 2;
  return [...theirs].every((w) => mine.has(w)) ? 1 : 0;
}

// The ids of the buildings that an id or an address may mean; one if it is clear.
export function meant(asked: string, known: { id: string; addresses: string[] }[]): string[] {
  const name = asked.trim().toLowerCase();
  const named = known.find((b) => b.id.toLowerCase() === name);
  if (named) return [named.id];
  const wanted = parseAddress(asked);
  const marks = known.map((b) => Math.max(0, ...b.addresses.map((a) => match(wanted, parseAddress(a)))));
  const best = Math.max(0, ...marks);
  return best ? known.filter((_, k) => marks[k] === best).map((b) => b.id) : [];
}

// The number in front, else the one that ends a part between commas, else the last; never a postcode.
function houseNumber(plain: string): RegExpMatchArray & { index: number } | null {
  const found = [...plain.matchAll(NUMBER)] as (RegExpMatchArray & { index: number })[];
  const first = found[0];
  if (!first || first.index === 0) return first ?? null;
  const ending = found.find((m) => {
    const after = plain.slice(m.index + m[0].length).trimStart();
    return !after || after.startsWith(",");
  });
  return ending ?? found[found.length - 1] ?? null;
}

function short(word: string): string {
  return word.endsWith("strasse") ? word.slice(0, -4) : SHORT[word] ?? word;
}

function* numbers(found: RegExpMatchArray): Iterable<string> {
  const [, first = "", letter, last, lastLetter] = found;
  yield first + (letter ?? "");
  if (last === undefined) return;
  yield last + (lastLetter ?? "");
  const span = Number(last) - Number(first);
  if (span <= 0 || span >= 60) return;
  for (let n = Number(first); n < Number(last); n += 2 - (span % 2)) yield String(n);
}

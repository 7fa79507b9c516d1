// "13 rue Soufflot, floor 3, window 2": what a search means, by the rules of `frontage locate`.

import { meant } from "./address";
import type { FacadeEntry, OpeningEntry, Run } from "./data";

export interface Found { facade: FacadeEntry; opening: OpeningEntry | null }
export interface Suggestion extends Found { text: string; detail: string }
export type Answer = Found | { problem: string };

const DOORS = new Set(["door", "passage", "garage"]);
const ID = /^([^/]+[/_]F\d+)\/([A-Z]-?\d+-\d+)$/i;

export function locate(run: Run, text: string): Answer {
  const id = ID.exec(text.trim());
  if (id) return byId(run, id[1]!.replace("_", "/"), id[2]!);
  const { place, floor, window, door } = parse(text);
  if (!place) return { problem: "Type an address or the id of a building, then floor and window." };
  const facade = facadeOf(run, place);
  if ("problem" in facade) return facade;
  if (window === null && door === null && floor === null) return { facade, opening: null };
  if (floor === null || (window === null) === (door === null))
    return { problem: "Give a floor and one of window and door, such as “floor 3, window 2”." };
  const number = window ?? door;
  const opening = (facade.openings ?? []).find(
    (o) => o.floor === floor && o.number === number && (door === null || DOORS.has(o.kind)));
  return opening ? { facade, opening } : { problem: nothing(facade, floor, door === null ? "opening" : "door", number!) };
}

// What a beginning of a search may become, the best first.
export function suggestions(run: Run, text: string, most = 8): Suggestion[] {
  const typed = text.trim().toLowerCase();
  if (!typed) return [];
  const answer = locate(run, text);
  const first = "problem" in answer ? [] : [suggestion(run, answer)];
  const places = run.facades
    .map((facade) => suggestion(run, { facade, opening: null }))
    .filter((s) => s.text.toLowerCase().includes(typed) || s.facade.id.toLowerCase().includes(typed));
  const openings = run.facades.flatMap((facade) => (facade.openings ?? [])
    .filter((o) => o.id.toLowerCase().includes(typed))
    .map((opening) => suggestion(run, { facade, opening })));
  const all = [...first, ...places, ...openings];
  return all.filter((s, k) => all.findIndex((t) => key(t) === key(s)) === k).slice(0, most);
}

export function titleOf(run: Run, facade: FacadeEntry): string {
  const building = run.buildings.find((b) => b.id === facade.building);
  return building?.addresses[0] ?? facade.building;
}

export function storey(floor: number): string {
  if (floor < 0) return "basement";
  return floor === 0 ? "ground floor" : `floor ${floor}`;
}

function suggestion(run: Run, found: Found): Suggestion {
  const { facade, opening } = found;
  const title = titleOf(run, facade);
  if (!opening) return { ...found, text: title, detail: facade.id };
  return { ...found, text: `${title}, ${storey(opening.floor)}, ${opening.kind} ${opening.number}`, detail: opening.id };
}

const key = (s: Found) => s.opening?.id ?? s.facade.id;

interface Query { place: string; floor: number | null; window: number | null; door: number | null }

export function parse(text: string): Query {
  let rest = text;
  const take = (pattern: RegExp): number | null => {
    const found = pattern.exec(rest);
    if (!found) return null;
    rest = rest.slice(0, found.index) + "," + rest.slice(found.index + found[0].length);
    return found[1] === undefined ? 0 : Number(found[1]);
  };
  const floor = take(/(?:^|[\s,;])(?:floor|level|storey)\s+(-?\d+)(?=$|[\s,;])/i) ?? take(/(?:^|[\s,;])ground\s+floor(?=$|[\s,;])/i);
  const window = take(/(?:^|[\s,;])(?:window|opening)\s+(\d+)(?=$|[\s,;])/i);
  const door = take(/(?:^|[\s,;])(?:door|gate)\s+(\d+)(?=$|[\s,;])/i);
  return { place: rest.replace(/(?:\s*[,;]\s*)+/g, ", ").replace(/^[,\s]+|[,\s]+$/g, ""), floor, window, door };
}

function byId(run: Run, facadeId: string, name: string): Answer {
  const facade = run.facades.find((f) => f.id.toLowerCase() === facadeId.toLowerCase());
  if (!facade) return { problem: `There is no facade ${facadeId}.` };
  const wanted = `${facade.id}/${name}`.toLowerCase();
  const opening = (facade.openings ?? []).find((o) => o.id.toLowerCase() === wanted);
  return opening ? { facade, opening } : { problem: `There is no opening ${facade.id}/${name}.` };
}

function facadeOf(run: Run, place: string): FacadeEntry | { problem: string } {
  const named = run.facades.find((f) => f.id.toLowerCase() === place.toLowerCase().replace("_", "/"));
  if (named) return named;
  const found = meant(place, run.buildings);
  if (found.length > 1) return { problem: `“${place}” matches ${found.length} buildings: ${found.slice(0, 6).join(", ")}.` };
  const building = found[0];
  if (building === undefined) {
    const lost = meant(place, Object.keys(run.lost).map((a) => ({ id: a, addresses: [a] })))[0];
    return { problem: (lost && run.lost[lost]) || `No building has the address or id “${place}”.` };
  }
  const own = run.facades.filter((f) => f.building === building);
  const front = own.reduce<FacadeEntry | null>((best, f) => (best && count(best) >= count(f) ? best : f), null);
  return front ?? { problem: `${building} has no facade.` };
}

const count = (f: FacadeEntry) => f.openings?.length ?? -1;

function nothing(facade: FacadeEntry, floor: number, what: string, number: number): string {
  const there = (facade.openings ?? []).filter((o) => o.floor === floor).map((o) => o.id.split("/").pop());
  const tail = there.length ? `there are ${there.join(", ")}` : "nothing was found there";
  return `${facade.id} has no ${what} ${number} on floor ${floor}: ${tail}.`;
}

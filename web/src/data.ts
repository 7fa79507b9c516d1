// What the site holds: the shapes of run.json and facade.json, and how they are fetched.

export type Vec3 = [number, number, number];
export type Point = [number, number];

export interface OpeningEntry {
  id: string; kind: string; floor: number; number: number; bay: number;
  width: number; height: number; sigma: number | null;
  provenance: string; confidence: number; layout: string | null; center: Vec3;
}
export interface OrthoEntry { width: number; height: number; gsd: number; levels: number; corners: Vec3[] }
export interface FacadeEntry {
  id: string; building: string; path: string; outline: Vec3[]; center: Vec3; outward: Vec3; size: Point;
  ortho: OrthoEntry | null; openings: OpeningEntry[] | null;
}
export interface BuildingEntry { id: string; addresses: string[]; facades: string[]; ground: number | null }
export interface PhotoEntry { id: string; path: string; size: Point; at: Vec3 }
export interface BandAbout { unit: number; bytes: number; missing: number }
export type BandName = "depth" | "sources" | "resolution";
export interface Run {
  schema: number; frontage: string; name: string; crs: string | null; origin: Vec3; heights: string;
  buildings: BuildingEntry[]; lost: Record<string, string>; facades: FacadeEntry[]; photos: PhotoEntry[];
  blocks: number; bands: Record<BandName, BandAbout>;
  tiles: { path: string; matrix: number[]; before: string } | null;
  left_out: string[];
}

export interface PhotoView {
  photo: string; number: number; outline: Point[]; visible: number; angle: number; gsd: number;
}
export interface Bar { axis: "vertical" | "horizontal"; position: number; extent: Point; width: number }
export interface Opening {
  id: string; kind: string; shape: string; floor: number; number: number; bay: number;
  corners: Vec3[]; corners_inside: Vec3[] | null; center: Vec3;
  width: number; height: number; area: number; depth: number | null;
  sigma: Record<string, number | null>; provenance: string; confidence: number;
  glazing: { layout: string; confidence: number; note: string } | null;
  photos: PhotoView[]; tested: string; notes: string[];
  ring: Point[]; wall_y: number; bars: Bar[];
}
export interface Protrusion {
  id: string; kind: string; ring: Point[]; front: number; sigma_front: number | null; provenance: string;
}
export interface Ortho {
  width: number; height: number; gsd: number; corner: Point; raster_to_world: number[][]; relief: boolean;
  plane_variance: number[] | null; scatter: number | null; sources: string[]; photos: number;
}
export interface Picture { path: string; name: string; caption: string; extent: [number, number, number, number] }
export interface Facade {
  id: string; building: string; crs: string | null; outline: Point[]; notes: string[]; pictures: Picture[];
  ortho: Ortho | null; openings: Opening[] | null; protrusions: Protrusion[];
}

const SCHEMA = 1;

async function json<T>(path: string): Promise<T> {
  const response = await fetch(path);
  if (!response.ok) throw new Error((await response.text()).trim() || `${path} is missing`);
  return await response.json() as T;
}

export async function loadRun(): Promise<Run> {
  const run = await json<Run>("run.json");
  if (run.schema !== SCHEMA) throw new Error("The run was written for another version of the viewer; export it again.");
  return run;
}

const facades = new Map<string, Promise<Facade>>();

export function loadFacade(entry: FacadeEntry): Promise<Facade> {
  let found = facades.get(entry.id);
  if (!found) {
    found = json<Facade>(`${entry.path}/facade.json`);
    found.catch(() => facades.delete(entry.id));
    facades.set(entry.id, found);
  }
  return found;
}

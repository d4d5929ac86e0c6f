import { count, digits, flag, list, maybe, number, object, one_of, text, WireError, type Parser } from './parse';

export type JobState =
  | 'queued' | 'preparing' | 'rendering' | 'finalizing' | 'succeeded' | 'canceling' | 'canceled' | 'failed' | 'paused';
export type PauseReason = 'request' | 'disk_full' | 'disk_unreachable';
export type Priority = 'interactive' | 'batch';
export type Method = 'auto' | 'path' | 'photon_map' | 'progressive' | 'hybrid';

export interface Info {
  version: string;
  limits: Limits;
}

/** What the server accepts. */
export interface Limits {
  max_upload_bytes: number;
}

/** A scene as it is listed. */
export interface Scene {
  id: string;
  name: string;
  bytes: number;
  sample: boolean;
}

/** A part of the list; `next_cursor` leads on, null at its end. */
export interface ScenePage {
  scenes: Scene[];
  next_cursor: string | null;
}

export type Triple = [number, number, number];

/** A camera of a scene. */
export interface Camera {
  name: string;
  eye: Triple;
  /** Of length one, as `up` is, what is up in its picture. */
  direction: Triple;
  up: Triple;
  /** Null for an orthographic one. */
  yfov_deg: number | null;
}

/** A place to take a picture from. */
export interface Placement {
  eye: Triple;
  target: Triple;
  /** Without it +Y is up. */
  up?: Triple;
  yfov_deg: number;
}

/** A scene with what is in it. */
export interface SceneReport extends Scene {
  triangles: number;
  emissive_triangles: number;
  /** Points, spots and directional lights. */
  lights: number;
  /** Whether light comes from infinity. */
  environment: boolean;
  materials: number;
  cameras: Camera[];
  /** Of the bounds, in metres; null for an empty scene. */
  size: Triple | null;
  centre: Triple | null;
  /** What method auto would do. */
  plan: Plan;
  warnings: string[];
}

/** A map of the light from around. */
export interface Environment {
  id: string;
  name: string;
  width: number;
  height: number;
}

/** Which map, by how much it is turned about the vertical, and the factor of its radiance. */
export interface EnvironmentChoice {
  id: string;
  rotation_deg: number;
  scale: number;
}

export interface Plan {
  method: Method;
  /** The method does not converge to the right picture. */
  biased: boolean;
  uses_maps: boolean;
  items: PlanItem[];
}

/** One decision of a plan. */
export interface PlanItem {
  feature: string;
  active: boolean;
  reason: string;
}

/** A job ends at whichever comes first; null: no such end. */
export interface StopRule {
  passes: number | null;
  seconds: number | null;
  relative_error: number | null;
}

/** The numbers of a job that change while it runs; `version` grows with every change. */
export interface JobNumbers {
  state: JobState;
  version: number;
  passes: number;
  seconds: number;
  rejected_samples: number;
  /** Relative: √(noise² + bias²). */
  error: number | null;
  noise: number | null;
  /** The part of the error that more passes remove slowly; 0 where the method has none. */
  bias: number | null;
  eta_seconds: number | null;
  map_hits: number; // in memory or on disk
  map_disk_hits: number;
  map_misses: number;
  revision: number;
}

/** What a job was asked for, with what the server filled in. */
export interface JobSpec {
  environment: EnvironmentChoice | null;
  /** Index, name or place. */
  camera: number | string | Placement;
  film: { width: number; height: number };
  method: Method;
  photons_per_pass: number;
  radius: number;
  gather_photons: number;
  /** Digits: it may be larger than what a number holds exactly. */
  seed: string;
  stop: StopRule;
  priority: Priority;
}

export interface Job extends JobNumbers {
  id: string;
  /** As the server writes times: the texts are ordered as the times are. */
  created_at: string;
  scene: string;
  label: string;
  spec: JobSpec;
  plan: Plan | null;
  /** From leaving the queue to the first picture, on the wall clock. */
  first_frame_seconds: number | null;
  /** Why a paused job is; one that waits for room on the disk goes on by itself. */
  paused_because: PauseReason | null;
  /** Why a failed job failed. */
  failure: string | null;
}

/** A part of the list, newest first; `next_cursor` leads on to older ones, null at the end. */
export interface JobPage {
  jobs: Job[];
  next_cursor: string | null;
}

/** Something that happened to a job, with the numbers of that moment. */
export interface JobEvent extends JobNumbers {
  job: string;
}

/** One point of the curve of error against time. */
export interface SeriesPoint {
  seconds: number;
  error: number;
}

/** Why the server refused a request (RFC 9457). */
export interface Problem {
  title: string;
  detail: string;
  pointer: string;
}

/** What is sent to start a job; the server fills in what is missing. */
export interface JobRequest extends Partial<Omit<JobSpec, 'stop'>> {
  scene: string;
  stop: Partial<Record<keyof StopRule, number>>;
  label?: string;
}

export function is_terminal(state: JobState): boolean {
  return state === 'succeeded' || state === 'canceled' || state === 'failed';
}

const state = one_of(
  'queued', 'preparing', 'rendering', 'finalizing', 'succeeded', 'canceling', 'canceled', 'failed', 'paused',
);
const method = one_of('auto', 'path', 'photon_map', 'progressive', 'hybrid');

const plan = object<Plan>({
  method,
  biased: flag,
  uses_maps: flag,
  items: list(object<PlanItem>({ feature: text, active: flag, reason: text })),
});

const stop_rule = object<StopRule>({
  passes: maybe(count), seconds: maybe(number), relative_error: maybe(number),
});

/** The members that jobs and events share, as they are sent. */
const numbers = object({
  state,
  version: count,
  passes: count,
  seconds: number,
  rejected_samples: count,
  error: maybe(object({ relative: number, noise: number, bias: number })),
  eta_seconds: maybe(number),
  maps: object({ hits: count, disk_hits: count, misses: count }),
  revision: count,
});

const parse_numbers: Parser<JobNumbers> = (value, pointer) => {
  const { maps, error, ...rest } = numbers(value, pointer);
  const { relative, noise, bias } = error ?? { relative: null, noise: null, bias: null };
  return {
    ...rest, error: relative, noise, bias,
    map_hits: maps.hits, map_disk_hits: maps.disk_hits, map_misses: maps.misses,
  };
};

const vector: Parser<Triple> = (value, pointer) => {
  const [x, y, z, ...more] = list(number)(value, pointer);
  if (x === undefined || y === undefined || z === undefined || more.length > 0) throw new WireError(pointer, 'three numbers');
  return [x, y, z];
};

const placement = object({ eye: vector, target: vector, up: vector, yfov_deg: number });

const camera: Parser<JobSpec['camera']> = (value, pointer) => {
  if (typeof value === 'string') return value;
  return typeof value === 'number' ? count(value, pointer) : placement(value, pointer);
};

const spec = object<JobSpec>({
  environment: maybe(object<EnvironmentChoice>({ id: text, rotation_deg: number, scale: number })),
  camera,
  film: object({ width: count, height: count }),
  method,
  photons_per_pass: count,
  radius: number,
  gather_photons: count,
  seed: digits,
  stop: stop_rule,
  priority: one_of('interactive', 'batch'),
});

const job_frame = object({
  id: text,
  created_at: text,
  scene: text,
  label: text,
  spec,
  plan: maybe(plan),
  first_frame_seconds: maybe(number),
  paused_because: maybe(one_of('request', 'disk_full', 'disk_unreachable')),
  problem: maybe(object({ detail: text })),
});

export const parse_job: Parser<Job> = (value, pointer) => {
  const { problem, ...rest } = job_frame(value, pointer);
  return { ...rest, ...parse_numbers(value, pointer), failure: problem?.detail ?? null };
};

export const parse_jobs: Parser<JobPage> = object<JobPage>({ jobs: list(parse_job), next_cursor: maybe(text) });

export const parse_event: Parser<JobEvent> = (value, pointer) => ({
  ...object({ job: text })(value, pointer),
  ...parse_numbers(value, pointer),
});

/** Points without an error estimate are left out. */
export const parse_series: Parser<SeriesPoint[]> = (value, pointer) => {
  const point = object({ seconds: number, error: maybe(object({ relative: number })) });
  const { points } = object({ points: list(point) })(value, pointer);
  return points.flatMap(({ seconds, error }) => (error ? [{ seconds, error: error.relative }] : []));
};

const problem = object({ title: maybe(text), detail: maybe(text), pointer: maybe(text) });

export const parse_problem: Parser<Problem> = (value, pointer) => {
  const { title, detail, pointer: place } = problem(value, pointer);
  return { title: title ?? '', detail: detail ?? '', pointer: place ?? '' };
};

export const parse_info: Parser<Info> = object<Info>({
  version: text, limits: object<Limits>({ max_upload_bytes: count }),
});

const scene = object<Scene>({ id: text, name: text, bytes: count, sample: flag });

export const parse_scenes: Parser<ScenePage> = object<ScenePage>({ scenes: list(scene), next_cursor: maybe(text) });

export const parse_environment: Parser<Environment> =
  object<Environment>({ id: text, name: text, width: count, height: count });

export const parse_environments: Parser<Environment[]> = (value, pointer) =>
  object({ environments: list(parse_environment) })(value, pointer).environments;

const report = object({
  counts: object({ triangles: count, emissive_triangles: count }),
  bounds: maybe(object({ min: vector, max: vector })),
  environment: vector,
  cameras: list(object<Camera>({ name: text, eye: vector, direction: vector, up: vector, yfov_deg: maybe(number) })),
  lights: list(object({})),
  materials: list(object({})),
  warnings: list(text),
});

export const parse_report: Parser<SceneReport> = (value, pointer) => {
  const { report: found, plan: planned } = object({ report, plan })(value, pointer);
  const { bounds } = found;
  return {
    ...scene(value, pointer),
    triangles: found.counts.triangles,
    emissive_triangles: found.counts.emissive_triangles,
    lights: found.lights.length,
    environment: found.environment.some((radiance) => radiance > 0),
    materials: found.materials.length,
    cameras: found.cameras,
    size: bounds && by_axis((axis) => bounds.max[axis]! - bounds.min[axis]!),
    centre: bounds && by_axis((axis) => (bounds.max[axis]! + bounds.min[axis]!) / 2),
    plan: planned,
    warnings: found.warnings,
  };
};

function by_axis(value: (axis: number) => number): Triple {
  return [value(0), value(1), value(2)];
}

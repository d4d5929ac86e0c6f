import type { View } from './frames';
import { placement_of, readable } from './placement';
import {
  is_terminal, type Environment, type Info, type Job, type JobEvent, type JobPage, type Placement, type Scene, type SceneReport,
  type SeriesPoint,
} from './wire';

/** A job was deleted, as an event told; or is not known to the server, as an answer said. */
export type Absence = 'deleted' | 'unknown';

/** Everything the page shows, apart from the pixels of the picture and what is typed into the form. */
export interface State {
  /** Whether the event stream is open. */
  server: 'connecting' | 'online' | 'away' | 'locked';
  info: Info | null;
  scenes: Scene[];
  /** The id of the scene that is chosen in the form. */
  scene: string | null;
  environments: Environment[];
  /** The id of the environment that is chosen in the form; null: the scene's own. */
  environment: string | null;
  /** Reports fetched so far, or why there is none, by scene id. */
  reports: Record<string, SceneReport | string>;
  /** Newest first. */
  jobs: Job[];
  /** Leads on to jobs that are older than those of the list; null: there are none. */
  older: string | null;
  /** The id of the job that is looked at. */
  watched: string | null;
  /** What is looked at of it. */
  view: View;
  /** It took the place of another by steering: that one's picture is shown until it has one. */
  steered: boolean;
  /** Why there is no watched job. */
  missing: Absence | null;
  /** Ids of jobs that went lately: an answer that was on its way may still tell of them. */
  gone: string[];
  /** Error against time of the watched job, by ascending seconds. */
  series: SeriesPoint[];
  /** A sentence about the last thing that went wrong; null: nothing did. */
  notice: string | null;
}

export const kInitialState: State = {
  server: 'connecting', info: null, scenes: [], scene: null, environments: [], environment: null,
  reports: {}, jobs: [], older: null,
  watched: null, view: 'picture', steered: false, missing: null, gone: [], series: [], notice: null,
};

export type Action =
  | { type: 'server'; server: State['server'] }
  | { type: 'info'; info: Info }
  | { type: 'scenes'; scenes: Scene[] }
  | { type: 'scene_chosen'; scene: string }
  | { type: 'scene_added'; report: SceneReport }
  | { type: 'environments'; environments: Environment[] }
  | { type: 'environment_chosen'; environment: string | null }
  | { type: 'environment_added'; environment: Environment }
  | { type: 'report'; scene: string; report: SceneReport | string }
  | { type: 'jobs'; page: JobPage }
  | { type: 'older_jobs'; page: JobPage }
  | { type: 'job'; job: Job }
  | { type: 'series'; job: string; points: SeriesPoint[] }
  | { type: 'event'; event: JobEvent }
  | { type: 'watch'; job: string | null; steered?: boolean }
  | { type: 'view'; view: View }
  | { type: 'job_gone'; job: string; why: Absence }
  | { type: 'notice'; text: string | null };

/** The state after `action`. What is older than what is known never replaces it. */
export function reduce(state: State, action: Action): State {
  switch (action.type) {
    case 'server': return with_server(state, action.server);
    case 'info': return { ...state, info: action.info };
    case 'scenes': return with_scenes(state, action.scenes);
    case 'scene_chosen': return { ...state, scene: action.scene };
    case 'scene_added': return with_added_scene(state, action.report);
    case 'environments': return with_environments(state, action.environments);
    case 'environment_chosen': return { ...state, environment: action.environment };
    case 'environment_added': return with_added_environment(state, action.environment);
    case 'report': return { ...state, reports: { ...state.reports, [action.scene]: action.report } };
    case 'jobs': return with_jobs(state, action.page);
    case 'older_jobs': return with_older_jobs(state, action.page);
    case 'job': return with_job(state, action.job);
    case 'series': return action.job === state.watched ? with_points(state, action.points) : state;
    case 'event': return with_event(state, action.event);
    case 'watch': return with_watch(state, action.job, action.steered ?? false);
    case 'view': return { ...state, view: action.view };
    case 'job_gone': return without_job(state, action.job, action.why);
    case 'notice': return { ...state, notice: action.text };
  }
}

/** Whenever the server is there (again) everything is fetched anew, and what goes wrong then is said anew. */
function with_server(state: State, server: State['server']): State {
  return server === 'online' ? { ...state, server, gone: [], notice: null } : { ...state, server };
}

export function watched_job(state: State): Job | null {
  return find_job(state, state.watched);
}

export function find_job(state: State, id: string | null): Job | null {
  return state.jobs.find((job) => job.id === id) ?? null;
}

/** The report of the chosen scene, or why there is none; null while it is on its way. */
export function chosen_report(state: State): SceneReport | string | null {
  return state.scene === null ? null : state.reports[state.scene] ?? null;
}

/** Where the watched picture is taken from; null where that is not known, or cannot be turned. */
export function watched_placement(state: State): Placement | null {
  const job = watched_job(state);
  const report = job && state.reports[job.scene];
  if (!job) return null;
  const { camera } = job.spec;
  if (typeof camera === 'object') return readable(camera);
  if (!report || typeof report === 'string') return null;
  const found = typeof camera === 'number' ? report.cameras[camera] : report.cameras.find(({ name }) => name === camera);
  return found && found.yfov_deg !== null ? placement_of(found, report) : null;
}

/** A name for people: the scene's, else the start of its id. */
export function scene_name(state: State, id: string): string {
  const scene = state.scenes.find((known) => known.id === id);
  return scene ? scene_title(scene) : `scene ${id.slice(0, 8)}`;
}

export function scene_title(scene: Scene): string {
  if (scene.name === '') return `scene ${scene.id.slice(0, 8)}`;
  return scene.sample ? scene.name.replaceAll('_', ' ') : scene.name;
}

function with_scenes(state: State, scenes: Scene[]): State {
  // A list may be older than an upload, or end before it: what is chosen and known stays.
  const report = chosen_report(state);
  const unlisted = report && typeof report !== 'string' && !scenes.some(({ id }) => id === report.id) ? [report] : [];
  const all: Scene[] = [...scenes, ...unlisted];
  const chosen = all.some((scene) => scene.id === state.scene) ? state.scene : all[0]?.id ?? null;
  return { ...state, scenes: all, scene: chosen };
}

function with_added_scene(state: State, report: SceneReport): State {
  const known = state.scenes.some((scene) => scene.id === report.id);
  const scenes = known
    ? state.scenes.map((scene) => (scene.id === report.id ? report : scene))
    : [...state.scenes, report];
  return { ...state, scenes, scene: report.id, reports: { ...state.reports, [report.id]: report } };
}

/** `sky.hdr, 2048 × 1024`. */
export function environment_title({ id, name, width, height }: Environment): string {
  return `${name || `map ${id.slice(0, 8)}`}, ${width} × ${height}`;
}

function with_environments(state: State, environments: Environment[]): State {
  const chosen = environments.some((map) => map.id === state.environment) ? state.environment : null;
  return { ...state, environments, environment: chosen };
}

function with_added_environment(state: State, environment: Environment): State {
  const others = state.environments.filter((known) => known.id !== environment.id);
  return { ...state, environments: [...others, environment], environment: environment.id };
}

function with_jobs(state: State, { jobs, next_cursor }: JobPage): State {
  const watched = watched_job(state);
  const listed = known_or_newer(state, jobs);
  return { ...state, jobs: by_age(watched ? [...listed, watched] : listed), older: next_cursor };
}

function with_older_jobs(state: State, { jobs, next_cursor }: JobPage): State {
  return { ...state, jobs: by_age([...known_or_newer(state, jobs), ...state.jobs]), older: next_cursor };
}

function with_job(state: State, job: Job): State {
  const there = known_or_newer(state, [job]);
  const missing = there.some(({ id }) => id === state.watched) ? null : state.missing;
  return { ...state, jobs: by_age([...there, ...state.jobs]), missing };
}

/** Without those that are gone. */
function known_or_newer(state: State, jobs: Job[]): Job[] {
  return jobs.filter(({ id }) => !state.gone.includes(id)).map((job) => newest(job, find_job(state, job.id)));
}

/** Newest first; of two of the same id the one that comes first. */
function by_age(jobs: Job[]): Job[] {
  const first = new Map<string, Job>();
  for (const job of jobs) if (!first.has(job.id)) first.set(job.id, job);
  return [...first.values()].sort((a, b) => (a.created_at < b.created_at ? 1 : a.created_at > b.created_at ? -1 : 0));
}

const kGone = 256; // of these are remembered: more than go while an answer is on its way

function without_job(state: State, id: string, why: Absence): State {
  const missing = id === state.watched ? state.missing ?? why : state.missing;
  const gone = [...state.gone.filter((other) => other !== id), id].slice(-kGone);
  return { ...state, jobs: state.jobs.filter((job) => job.id !== id), missing, gone };
}

function newest(candidate: Job, known: Job | null): Job {
  return known && known.version > candidate.version ? known : candidate;
}

function with_event(state: State, event: JobEvent): State {
  const known = find_job(state, event.job);
  if (!known || known.version > event.version) return state;
  const { job: id, ...numbers } = event;
  const eta_seconds = is_terminal(event.state) ? null : event.eta_seconds;
  const jobs = state.jobs.map((job) => (job.id === id ? { ...job, ...numbers, eta_seconds } : job));
  const next = { ...state, jobs };
  if (id !== state.watched || event.error === null || event.seconds <= 0) return next;
  return with_points(next, [{ seconds: event.seconds, error: event.error }]);
}

function with_points(state: State, points: SeriesPoint[]): State {
  const by_time = new Map([...state.series, ...points].map((point) => [point.seconds, point]));
  return { ...state, series: thinned([...by_time.values()].sort((a, b) => a.seconds - b.seconds)) };
}

const kLeastStep = 1.004; // between points: less is no pixel on a chart of logarithmic time

/** Without what nobody sees: a job may run for days, and tells of itself twice a second. */
function thinned(points: SeriesPoint[]): SeriesPoint[] {
  let last = 0;
  return points.filter(({ seconds }, index) => {
    if (seconds < last * kLeastStep && index < points.length - 1) return false;
    last = seconds;
    return true;
  });
}

function with_watch(state: State, job: string | null, steered: boolean): State {
  if (job === state.watched) return state;
  const view = steered ? 'picture' : state.view; // errors come later, and say nothing of the way
  return { ...state, watched: job, view, steered, missing: null, series: [], notice: null };
}

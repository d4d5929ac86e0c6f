import { reached } from './events';
import type { FrameKey, View } from './frames';
import { read_json, write_json } from './json';
import { fetch_with_key } from './key';
import { WireError, type Parser } from './parse';
import {
  parse_environment, parse_environments, parse_info, parse_job, parse_jobs, parse_problem, parse_report, parse_scenes,
  parse_series, type Environment, type Job, type JobRequest, type Problem, type Scene, type SceneReport,
} from './wire';

/** Why a request brought nothing: the server did not answer, or answered with a problem. */
export type Failure = { kind: 'away' } | { kind: 'problem'; status: number; problem: Problem };
export type Answer<T> = { ok: true; value: T } | { ok: false; failure: Failure };

/** Decoded pixels and the revision they are of. */
export interface FramePicture {
  bitmap: ImageBitmap;
  revision: number;
}

export type FrameFormat = 'png' | 'jpg' | 'exr';

const kMostPages = 10; // of scenes: more than that is no list to choose from

export const api = {
  info: () => ask('v1/info', parse_info),
  scenes: () => all_scenes(),
  scene: (id: string) => ask(`v1/scenes/${id}`, parse_report),
  /** The newest jobs; with a cursor those that come after it. */
  jobs: (cursor: string | null = null) =>
    ask(`v1/jobs?limit=50${cursor === null ? '' : `&cursor=${cursor}`}`, parse_jobs),
  job: (id: string) => ask(`v1/jobs/${id}`, parse_job),
  series: (id: string) => ask(`v1/jobs/${id}/series`, parse_series),
  upload: (file: Blob, media_type: string, name: string): Promise<Answer<SceneReport>> =>
    ask(named('v1/scenes', name), parse_report,
      { method: 'POST', body: file, headers: { 'Content-Type': media_type } }),
  environments: () => ask('v1/environments', parse_environments),
  upload_environment: (file: Blob, name: string): Promise<Answer<Environment>> =>
    ask(named('v1/environments', name), parse_environment,
      { method: 'POST', body: file, headers: { 'Content-Type': 'application/octet-stream' } }),
  submit: (job: JobRequest): Promise<Answer<Job>> =>
    ask('v1/jobs', parse_job, json_post(job)),
  /** What needs no more than the job. */
  act: (id: string, action: 'cancel' | 'pause' | 'resume' | 'retry') =>
    ask(`v1/jobs/${id}/${action}`, parse_job, { method: 'POST' }),
  /** A job that has ended. */
  remove: (id: string) => ask(`v1/jobs/${id}`, nothing, { method: 'DELETE' }),
  extend: (id: string, stop: JobRequest['stop']) => ask(`v1/jobs/${id}/extend`, parse_job, json_post({ stop })),
};

export function frame_url(job: string, revision: number | 'latest', format: FrameFormat, view: View = 'picture'): string {
  return `v1/jobs/${job}/frames/${revision}.${format}${view === 'error' ? '?layer=error.bound' : ''}`;
}

/** Events of all jobs, from now on. */
export const kEventsUrl = 'v1/events';

/** A sentence for people. */
export function describe(failure: Failure): string {
  if (failure.kind === 'away') return 'The server does not answer.';
  const { title, detail } = failure.problem;
  return sentence(detail || title || `The server answered ${failure.status}.`);
}

/** A file to be saved. An answer without one, as a 204, is a failure too. */
export async function fetch_file(path: string): Promise<Answer<Blob>> {
  const response = await reached(fetch_with_key(path));
  const body = response && await reached(response.blob());
  if (!response || !body) return { ok: false, failure: { kind: 'away' } };
  return response.status === 200
    ? { ok: true, value: body }
    : { ok: false, failure: refusal(response.status, await body.text()) };
}

/**
 * The newest picture of the job of `key`, which is that of `key` or a later one: older ones are not kept for long. Null
 * where there is none, 'later' where the server is busy or away. Errors come with the pictures after the first look at one.
 */
export async function load_frame(key: FrameKey, signal: AbortSignal): Promise<FramePicture | 'later' | null> {
  const format = key.lossless ? 'png' : 'jpg';
  const url = frame_url(key.job, 'latest', format, key.view);
  const response = await reached(fetch_with_key(url, { signal, cache: 'no-store' }));
  if (!response || response.status === 429 || response.status >= 500) return 'later';
  if (response.status !== 200) return null;
  const blob = await reached(response.blob());
  const bitmap = blob && await decoded(blob);
  return bitmap ? { bitmap, revision: revision_of(response) ?? key.revision } : 'later';
}

/** Null where it is no picture: something on the way may have broken it. */
async function decoded(blob: Blob): Promise<ImageBitmap | null> {
  try {
    return await createImageBitmap(blob);
  } catch (error) {
    if (error instanceof DOMException) return null;
    throw error;
  }
}

/** The revision that Content-Location names (`…/frames/7.jpg`, perhaps with the layer behind it). */
function revision_of(response: Response): number | null {
  const found = /\/frames\/(\d+)\.\w+(\?|$)/.exec(response.headers.get('Content-Location') ?? '');
  return found ? Number(found[1]) : null;
}

function named(path: string, name: string): string {
  return `${path}?${new URLSearchParams({ name })}`;
}

/** The scenes of the first pages. */
async function all_scenes(): Promise<Answer<Scene[]>> {
  const scenes: Scene[] = [];
  let cursor: string | null = null;
  for (let page = 0; page < kMostPages; ++page) {
    const from: string = cursor === null ? '' : `&cursor=${cursor}`;
    const answer = await ask(`v1/scenes?limit=200${from}`, parse_scenes);
    if (!answer.ok) return answer;
    scenes.push(...answer.value.scenes);
    cursor = answer.value.next_cursor;
    if (cursor === null) break;
  }
  return { ok: true, value: scenes };
}

/** Of an answer that is empty. */
const nothing: Parser<null> = () => null;

function json_post(body: unknown): RequestInit {
  return { method: 'POST', body: write_json(body), headers: { 'Content-Type': 'application/json' } };
}

async function ask<T>(path: string, parser: Parser<T>, init: RequestInit = {}): Promise<Answer<T>> {
  const response = await reached(fetch_with_key(path, { cache: 'no-store', ...init }));
  const body = response && await reached(response.text());
  if (!response || body === null) return { ok: false, failure: { kind: 'away' } };
  if (!response.ok) return { ok: false, failure: refusal(response.status, body) };
  try {
    return { ok: true, value: parser(body === '' ? null : read_json(body), '') };
  } catch (error) {
    return { ok: false, failure: { kind: 'problem', status: response.status, problem: unreadable(path, error) } };
  }
}

function refusal(status: number, body: string): Failure {
  // A gateway in front of the service answers for a service that is away.
  if (status === 502 || status === 504) return { kind: 'away' };
  try {
    return { kind: 'problem', status, problem: parse_problem(JSON.parse(body), '') };
  } catch (error) {
    if (!(error instanceof SyntaxError || error instanceof WireError)) throw error;
    return { kind: 'problem', status, problem: { title: '', detail: `The server answered ${status}.`, pointer: '' } };
  }
}

function unreadable(path: string, error: unknown): Problem {
  if (!(error instanceof SyntaxError || error instanceof WireError)) throw error;
  return { title: '', detail: `The server's answer to ${path} is not understood: ${error.message}.`, pointer: '' };
}

/** With a capital at its start and a mark at its end. */
export function sentence(words: string): string {
  const start = words.charAt(0).toUpperCase() + words.slice(1);
  return /[.!?]$/.test(start) ? start : `${start}.`;
}

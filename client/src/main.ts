import { api, describe, kEventsUrl, load_frame, type Failure } from './api';
import { by_id, set_text } from './dom';
import { follow } from './events';
import { FrameLoader, type View } from './frames';
import { follow_gestures } from './gestures';
import { JobForm } from './job_form';
import { JobList } from './job_list';
import { further, JobPanel, type JobAction } from './job_panel';
import { set_up_key } from './key_dialog';
import { kStateNames, job_title, label_of } from './names';
import { WireError } from './parse';
import type { SseMessage } from './sse';
import {
  find_job, kInitialState, reduce, watched_job, watched_placement, type Absence, type Action, type State,
} from './state';
import { Steering } from './steering';
import { is_environment, kEnvironments, kScenes, upload } from './uploads';
import { Viewer } from './viewer';
import { is_terminal, parse_event, type Job, type JobEvent, type JobPage, type JobRequest } from './wire';

let state: State = kInitialState;
let rendering = false;
let stream: { stop(): void } | null = null;

const viewer = new Viewer((view) => show(view));
const panel = new JobPanel(
  (id, action) => void act(id, action),
  (words) => dispatch({ type: 'notice', text: words }));
const list = new JobList(() => void load_older_jobs());
const form = new JobForm({
  on_scene: (scene) => choose_scene(scene),
  on_environment: (environment) => dispatch({ type: 'environment_chosen', environment }),
  on_files: (files) => take_files(files),
  on_submit: (request) => void submit(request),
});
const steering = new Steering({
  watched: () => watched_job(state),
  submit: (request) => api.submit(request),
  cancel: (id) => api.act(id, 'cancel'),
  pause: (id) => api.act(id, 'pause'),
  remove: (id) => api.remove(id),
  succeed: (job, stays) => succeed(job, stays),
  forget: (id) => forget(id, 'deleted'),
  fail: (failure) => dispatch({ type: 'notice', text: describe(failure) }),
});
const end_drag = follow_gestures(
  by_id('picture', HTMLCanvasElement),
  () => steering.next() ?? watched_placement(state),
  (to) => steering.look(to));
const frames = new FrameLoader(load_frame, (picture, key) => {
  const job = find_job(state, key.job);
  const name = job ? job_title(state, job) : 'the job';
  viewer.draw(picture, key, `${key.view === 'error' ? 'Error' : 'Picture'} of ${name}, revision ${key.revision}`);
  steering.arrived(key.job);
});

function dispatch(action: Action): void {
  state = reduce(state, action);
  if (rendering) return;
  rendering = true;
  queueMicrotask(() => {
    rendering = false;
    render();
  });
}

function render(): void {
  const job = watched_job(state);
  viewer.render(state);
  panel.render(state);
  form.render(state);
  list.render(state);
  const server = by_id('server', HTMLElement);
  server.dataset['server'] = state.server;
  set_text(server, server_text());
  const notice = by_id('notice', HTMLElement);
  notice.hidden = state.notice === null;
  set_text(notice, state.notice ?? '');
  document.title = job ? `${job_title(state, job)}: ${kStateNames[job.state]} – photond` : 'photond';
}

function server_text(): string {
  switch (state.server) {
    case 'connecting': return 'Connecting …';
    case 'locked': return 'The server asks for a key.';
    case 'away': return 'No connection to the server; trying again …';
    case 'online': return state.info ? `Connected to photond ${state.info.version}` : 'Connected';
  }
}

/** Shows why a request in the background brought nothing. That the server is away shows by the stream. */
function note_failure(failure: Failure): void {
  if (failure.kind === 'problem') dispatch({ type: 'notice', text: describe(failure) });
}

/** Brings everything up to date; events tell of what comes after. */
async function load_all(): Promise<void> {
  if (state.watched !== null) void load_watched(state.watched);
  const [info, scenes, environments, jobs] =
    await Promise.all([api.info(), api.scenes(), api.environments(), api.jobs()]);
  if (info.ok) dispatch({ type: 'info', info: info.value });
  else note_failure(info.failure);
  if (jobs.ok) dispatch({ type: 'jobs', page: without_left(jobs.value) });
  else note_failure(jobs.failure);
  if (scenes.ok) dispatch({ type: 'scenes', scenes: scenes.value });
  else note_failure(scenes.failure);
  if (environments.ok) dispatch({ type: 'environments', environments: environments.value });
  else note_failure(environments.failure);
  if (state.scene !== null) await load_report(state.scene);
}

async function load_older_jobs(): Promise<void> {
  const jobs = await api.jobs(state.older);
  if (jobs.ok) dispatch({ type: 'older_jobs', page: without_left(jobs.value) });
  else note_failure(jobs.failure);
}

function without_left({ jobs, next_cursor }: JobPage): JobPage {
  return { jobs: jobs.filter((job) => !steering.has_left(job)), next_cursor };
}

function choose_scene(scene: string): void {
  dispatch({ type: 'scene_chosen', scene });
  void load_report(scene);
}

async function load_report(scene: string): Promise<void> {
  if (typeof state.reports[scene] === 'object') return;
  const report = await api.scene(scene);
  if (report.ok) dispatch({ type: 'report', scene, report: report.value });
  else if (report.failure.kind === 'problem') dispatch({ type: 'report', scene, report: describe(report.failure) });
}

/** Takes a scene, a picture of the surroundings, or one of each. */
function take_files(files: File[]): void {
  const limit = state.info?.limits.max_upload_bytes ?? null;
  const maps = files.filter(is_environment);
  const scenes = files.filter((file) => !is_environment(file));
  void upload(maps, kEnvironments, limit, (...words) => form.show_environment_upload(...words)).then((environment) => {
    if (environment) dispatch({ type: 'environment_added', environment });
  });
  void upload(scenes, kScenes, limit, (...words) => form.show_upload(...words)).then((report) => {
    if (report) dispatch({ type: 'scene_added', report });
  });
}

async function submit(request: JobRequest): Promise<void> {
  form.set_busy(true);
  const scene = state.scenes.find((known) => known.id === request.scene);
  const label = scene && !scene.sample ? label_of(scene.name) : '';
  const answer = await api.submit({ ...request, label });
  form.set_busy(false);
  if (!answer.ok) return form.show_failure(answer.failure);
  dispatch({ type: 'job', job: answer.value });
  steering.begin(answer.value.id);
  location.hash = `job=${answer.value.id}`;
  watch_hash();
  queueMicrotask(() => panel.focus());
}

/** A job that steering has started takes the place of the one before. */
function succeed(job: Job, stays: boolean): void {
  dispatch({ type: 'job', job });
  dispatch({ type: 'watch', job: job.id, steered: true });
  show_newest(job.id);
  if (stays) history.pushState(null, '', `#job=${job.id}`);
  else history.replaceState(null, '', `#job=${job.id}`);
  if (typeof job.spec.camera === 'object') form.look_from(job.scene, job.spec.camera);
}

async function act(id: string, action: JobAction): Promise<void> {
  const job = find_job(state, id);
  if (!job) return;
  dispatch({ type: 'notice', text: null });
  const answer = await (action === 'extend' ? api.extend(id, further(job)) : api.act(id, action));
  if (answer.ok) dispatch({ type: 'job', job: answer.value });
  else if (!await has_moved_on(job, answer.failure)) dispatch({ type: 'notice', text: describe(answer.failure) });
}

/** Whether the job turns out to be gone, or in another state than was shown, which says enough. */
async function has_moved_on(job: Job, failure: Failure): Promise<boolean> {
  if (failure.kind !== 'problem' || (failure.status !== 409 && failure.status !== 404)) return false;
  await load_job(job.id);
  return find_job(state, job.id)?.state !== job.state;
}

function watch_hash(): void {
  const id = /^#job=([\w-]+)$/.exec(location.hash)?.[1] ?? null;
  if (id !== state.watched) watch(id);
}

/** Shows this of the watched job from now on. */
function show(view: View): void {
  dispatch({ type: 'view', view });
  if (state.watched !== null) show_newest(state.watched);
}

/** Shows the newest picture that is known of this job, and those that come. */
function show_newest(id: string): void {
  frames.watch({ job: id, view: state.view });
  const job = find_job(state, id);
  if (job) announce_frame(id, job);
}

/** Shows this job from now on. */
function watch(id: string | null): void {
  end_drag();
  steering.stop();
  dispatch({ type: 'watch', job: id });
  frames.watch(id === null ? null : { job: id, view: state.view });
  if (id !== null) void load_watched(id);
}

async function load_watched(id: string): Promise<void> {
  const [, series] = await Promise.all([load_job(id), api.series(id)]);
  if (series.ok) dispatch({ type: 'series', job: id, points: series.value });
}

/** The job is no more, or is not to be seen any more. */
function forget(id: string, why: Absence): void {
  dispatch({ type: 'job_gone', job: id, why });
  if (id === state.watched) frames.watch(null);
  steering.arrived(id);
}

/** Fetches a job and its newest picture. */
async function load_job(id: string): Promise<void> {
  const answer = await api.job(id);
  if (answer.ok) {
    if (steering.has_left(answer.value)) return;
    dispatch({ type: 'job', job: answer.value });
    announce_frame(id, answer.value);
    if (id === state.watched && typeof answer.value.spec.camera !== 'object') await load_report(answer.value.scene);
  } else if (answer.failure.kind === 'problem' && answer.failure.status === 404) {
    forget(id, 'unknown');
  } else {
    note_failure(answer.failure);
  }
}

/** One stream tells of all jobs. It is open only while somebody can see the page: browsers allow few connections. */
function follow_events(): void {
  stream?.stop();
  stream = document.hidden ? null : follow(kEventsUrl, {
    on_open: () => {
      dispatch({ type: 'server', server: 'online' });
      void load_all();
    },
    on_message: take_message,
    on_lost: () => dispatch({ type: 'server', server: 'away' }),
    on_locked: () => dispatch({ type: 'server', server: 'locked' }),
  });
}

function take_message(message: SseMessage): void {
  if (!['state', 'progress', 'frame', 'gone'].includes(message.event)) return;
  try {
    const event = parse_event(JSON.parse(message.data), '');
    if (message.event === 'gone') forget(event.job, 'deleted');
    else take_event(event);
  } catch (error) {
    if (!(error instanceof SyntaxError || error instanceof WireError)) throw error;
    dispatch({ type: 'notice', text: `An event of the server is not understood: ${error.message}.` });
  }
}

function take_event(event: JobEvent): void {
  if (steering.has_left({ id: event.job, state: event.state })) return;
  const before = find_job(state, event.job);
  dispatch({ type: 'event', event });
  announce_frame(event.job, event);
  if (is_terminal(event.state) && event.revision === 0) steering.arrived(event.job);
  // Events carry numbers; what else changes with the state or the first picture is in the job.
  if (before?.state !== event.state || (before.revision === 0 && event.revision > 0)) void load_job(event.job);
}

function announce_frame(job: string, { revision, state: now }: Pick<Job, 'revision' | 'state'>): void {
  if (revision > 0) frames.announce({ job, view: state.view, revision, lossless: is_terminal(now) });
}

addEventListener('hashchange', watch_hash);
document.addEventListener('visibilitychange', follow_events);

set_up_key();
render();
watch_hash();
follow_events();

import { describe, expect, it } from 'vitest';
import { environment_title, kInitialState, reduce, scene_name, watched_job, watched_placement, type Action, type State } from '../src/state';
import { parse_report, type Job, type JobPage, type JobSpec, type Placement, type Scene } from '../src/wire';
import { a_job, a_spec, an_event, scene_message } from './messages';

const after = (state: State, ...actions: Action[]) => actions.reduce(reduce, state);
const watching: State = { ...kInitialState, jobs: [a_job()], watched: 'j-1' };
const a_page = (jobs: Job[], next_cursor: string | null = null): JobPage => ({ jobs, next_cursor });
const a_scene = (id: string, name: string): Scene => ({ id, name, bytes: 10, sample: name !== '' });

describe('where the watched picture is taken from', () => {
  const report = parse_report(scene_message({ id: 'ab'.repeat(32) }), '');
  const known = after(watching, { type: 'report', scene: report.id, report });
  const watching_from = (camera: JobSpec['camera']) => ({ ...known, jobs: [a_job({ spec: a_spec({ camera }) })] });

  it('is a camera of the scene, by index or name', () => {
    expect(watched_placement(watching_from(0))).toMatchObject({ eye: [0, 0, 0], target: [0, 0, -0.377492], yfov_deg: 40 });
    expect(watched_placement(watching_from('main'))).toEqual(watched_placement(watching_from(0)));
    expect(watched_placement(watching_from('other'))).toBeNull();
    expect(watched_placement(watching_from(1))).toBeNull();
  });

  it('is a place, whatever is known of the scene', () => {
    const place: Placement = { eye: [1, 2, 3], target: [0, 0, 0], up: [0, 0, 1], yfov_deg: 30 };
    expect(watched_placement({ ...watching_from(place), reports: {} })).toEqual(place);
  });

  it('is not known without the scene\'s report, of an orthographic camera, or while nothing is watched', () => {
    expect(watched_placement(watching)).toBeNull();
    expect(watched_placement(after(watching, { type: 'report', scene: report.id, report: 'gone' }))).toBeNull();
    const cameras = report.cameras.map((camera) => ({ ...camera, yfov_deg: null }));
    expect(watched_placement({ ...known, reports: { [report.id]: { ...report, cameras } } })).toBeNull();
    expect(watched_placement({ ...known, watched: null })).toBeNull();
  });
});

describe('steering', () => {
  it('shows pictures: errors come later, and say nothing of the way', () => {
    const looking = after(watching, { type: 'view', view: 'error' });
    expect(after(looking, { type: 'watch', job: 'j-2', steered: true }).view).toBe('picture');
    expect(after(looking, { type: 'watch', job: 'j-2' }).view).toBe('error');
  });
});

describe('jobs', () => {
  it('takes the numbers of a newer event', () => {
    const job = watched_job(after(watching, { type: 'event', event: an_event() }));
    expect(job).toMatchObject({ version: 6, passes: 4, error: 0.2, revision: 3, map_hits: 3, id: 'j-1' });
  });

  it('is not changed by an older event, job or list', () => {
    const old = a_job({ version: 4, passes: 1 });
    expect(after(watching, { type: 'event', event: an_event({ version: 4, passes: 1 }) })).toEqual(watching);
    expect(after(watching, { type: 'job', job: old }).jobs).toEqual(watching.jobs);
    expect(after(watching, { type: 'jobs', page: a_page([old]) }).jobs).toEqual(watching.jobs);
  });

  it('ignores events of jobs it does not know', () => {
    expect(after(watching, { type: 'event', event: an_event({ job: 'j-2' }) })).toEqual(watching);
  });

  it('puts a new job first', () => {
    const jobs = after(watching, { type: 'job', job: a_job({ id: 'j-2' }) }).jobs;
    expect(jobs.map((job) => job.id)).toEqual(['j-2', 'j-1']);
  });

  it('keeps the watched job though the list does not reach back to it', () => {
    const jobs = after(watching, { type: 'jobs', page: a_page([a_job({ id: 'j-9' })]) }).jobs;
    expect(jobs.map((job) => job.id)).toEqual(['j-9', 'j-1']);
  });

  it('lists jobs by their age, in whatever order they come to be known', () => {
    const job_of = (minute: number) => a_job({ id: `j-${minute}`, created_at: `2026-01-31T12:0${minute}:00.000Z` });
    const first = after(kInitialState, { type: 'jobs', page: a_page([job_of(5), job_of(4)], 'c-4') });
    expect(first.older).toBe('c-4');
    const linked = after(first, { type: 'job', job: job_of(1) }, { type: 'job', job: job_of(6) });
    expect(linked.jobs.map((job) => job.id)).toEqual(['j-6', 'j-5', 'j-4', 'j-1']);
    const all = after(linked, { type: 'older_jobs', page: a_page([job_of(3), job_of(2), job_of(1)]) });
    expect(all.jobs.map((job) => job.id)).toEqual(['j-6', 'j-5', 'j-4', 'j-3', 'j-2', 'j-1']);
    expect(all.older).toBeNull();
  });

  it('has no time left once it has ended', () => {
    const event = an_event({ state: 'canceled', eta_seconds: 3 });
    expect(watched_job(after(watching, { type: 'event', event }))).toMatchObject({ state: 'canceled', eta_seconds: null });
  });

  it('forgets a job that is gone', () => {
    const gone = after(watching, { type: 'job_gone', job: 'j-1', why: 'deleted' });
    expect(gone).toMatchObject({ jobs: [], missing: 'deleted' });
    expect(after(gone, { type: 'job_gone', job: 'j-1', why: 'unknown' }).missing).toBe('deleted');
    expect(after(gone, { type: 'watch', job: 'j-2' }).missing).toBeNull();
    expect(after(watching, { type: 'job_gone', job: 'j-7', why: 'unknown' }).missing).toBeNull();
  });

  it('is not told of a job that is gone by an answer that was on its way', () => {
    const gone = after(watching, { type: 'job_gone', job: 'j-1', why: 'deleted' });
    const late = after(gone, { type: 'job', job: a_job() },
      { type: 'jobs', page: { jobs: [a_job()], next_cursor: null } },
      { type: 'older_jobs', page: { jobs: [a_job()], next_cursor: null } }, { type: 'event', event: an_event() });
    expect(late).toMatchObject({ jobs: [], missing: 'deleted' });
    const anew = after(gone, { type: 'server', server: 'online' }, { type: 'job', job: a_job() });
    expect(anew).toMatchObject({ jobs: [{ id: 'j-1' }], missing: null });
  });
});

describe('the curve of the watched job', () => {
  const points = (state: State) => state.series.map(({ seconds, error }) => [seconds, error]);

  it('joins series and events in the order of time, once each', () => {
    const state = after(watching,
      { type: 'event', event: an_event({ seconds: 2, error: 0.2 }) },
      { type: 'series', job: 'j-1', points: [{ seconds: 1, error: 0.4 }, { seconds: 2, error: 0.2 }] },
      { type: 'event', event: an_event({ version: 7, seconds: 3, error: 0.1 }) });
    expect(points(state)).toEqual([[1, 0.4], [2, 0.2], [3, 0.1]]);
  });

  it('keeps the newest point, and of the others no more than can be told apart', () => {
    const whole = Array.from({ length: 4000 }, (_, index) => ({ seconds: (index + 1) / 2, error: 0.5 }));
    const state = after(watching, { type: 'series', job: 'j-1', points: whole });
    expect(state.series.length).toBeLessThan(1500);
    expect(state.series.slice(0, 3)).toEqual(whole.slice(0, 3));
    expect(state.series.at(-1)).toEqual(whole.at(-1));
    const newer = Array.from({ length: 10 }, (_, index) => an_event({ seconds: 2001 + index, error: 0.4 }));
    const later = after(state, ...newer.map((event) => ({ type: 'event', event }) as const));
    expect(later.series.length).toBeLessThan(state.series.length + 5);
    expect(later.series.at(-1)).toEqual({ seconds: 2010, error: 0.4 });
  });

  it('takes nothing of other jobs, nor points without an error', () => {
    const both: State = { ...watching, jobs: [...watching.jobs, a_job({ id: 'j-2' })] };
    const state = after(both,
      { type: 'event', event: an_event({ job: 'j-2' }) },
      { type: 'event', event: an_event({ error: null }) },
      { type: 'series', job: 'j-2', points: [{ seconds: 1, error: 1 }] });
    expect(points(state)).toEqual([]);
  });

  it('begins anew with another job, and stays with the same', () => {
    const state = after(watching, { type: 'event', event: an_event() });
    expect(points(after(state, { type: 'watch', job: 'j-1' }))).toHaveLength(1);
    expect(points(after(state, { type: 'watch', job: 'j-2' }))).toHaveLength(0);
  });
});

describe('scenes', () => {
  it('chooses the first, and keeps a choice that is still there', () => {
    const scenes = [a_scene('a', 'box'), a_scene('b', 'pool')];
    const state = after(kInitialState, { type: 'scenes', scenes });
    expect(state.scene).toBe('a');
    expect(after(state, { type: 'scene_chosen', scene: 'b' }, { type: 'scenes', scenes }).scene).toBe('b');
    expect(after(state, { type: 'scenes', scenes: [] }).scene).toBeNull();
  });

  it('keeps an upload that a list does not name: it may be older, or end before it', () => {
    const report = { ...parse_report(scene_message(), ''), ...a_scene('c', 'mine.glb') };
    const state = after(kInitialState, { type: 'scene_added', report }, { type: 'scenes', scenes: [a_scene('a', 'box')] });
    expect(state.scene).toBe('c');
    expect(state.scenes.map(({ id }) => id)).toEqual(['a', 'c']);
    const other = after(state, { type: 'scene_chosen', scene: 'a' }, { type: 'scenes', scenes: [a_scene('a', 'box')] });
    expect(other).toMatchObject({ scene: 'a', scenes: [{ id: 'a' }] });
  });

  it('takes the name that an upload has got', () => {
    const report = { ...parse_report(scene_message(), ''), ...a_scene('c', 'mine.glb'), sample: false };
    const listed = after(kInitialState, { type: 'scenes', scenes: [a_scene('c', ''), a_scene('d', '')] });
    const state = after(listed, { type: 'scene_added', report });
    expect(state.scenes.map(({ id, name }) => [id, name])).toEqual([['c', 'mine.glb'], ['d', '']]);
    expect(scene_name(state, 'c')).toBe('mine.glb');
    expect(scene_name(state, 'd'.repeat(64))).toBe('scene dddddddd');
  });
});

describe('the notice', () => {
  it('goes when the server is there again, from where everything is fetched anew', () => {
    const state = after(kInitialState, { type: 'notice', text: 'The server does not answer.' });
    expect(after(state, { type: 'server', server: 'away' }).notice).toBe('The server does not answer.');
    expect(after(state, { type: 'server', server: 'online' }).notice).toBeNull();
  });
});

describe('environments', () => {
  const sky = { id: 'cd'.repeat(32), name: 'sky.hdr', width: 8, height: 4 };

  it('are chosen once uploaded', () => {
    const state = after(kInitialState, { type: 'environment_added', environment: sky }, { type: 'environments', environments: [sky] });
    expect(state).toMatchObject({ environment: sky.id, environments: [sky] });
    expect(environment_title(sky)).toBe('sky.hdr, 8 × 4');
    expect(environment_title({ ...sky, name: '' })).toBe('map cdcdcdcd, 8 × 4');
  });

  it('are listed once though uploaded twice', () => {
    const state = after(kInitialState, { type: 'environment_added', environment: sky }, { type: 'environment_added', environment: { ...sky, name: 'same.hdr' } });
    expect(state.environments.map(({ name }) => name)).toEqual(['same.hdr']);
  });

  it('are left for the scene\'s own when the server has forgotten them, or when nobody wants one', () => {
    const chosen = after(kInitialState, { type: 'environment_added', environment: sky });
    expect(after(chosen, { type: 'environments', environments: [] }).environment).toBeNull();
    expect(after(chosen, { type: 'environment_chosen', environment: null })).toMatchObject({ environment: null, environments: [sky] });
  });
});

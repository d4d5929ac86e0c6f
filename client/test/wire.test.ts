import { describe, expect, it } from 'vitest';
import { WireError } from '../src/parse';
import { parse_environments, parse_event, parse_job, parse_jobs, parse_info, parse_problem, parse_report, parse_scenes, parse_series } from '../src/wire';
import { a_job, an_event, event_message, job_message, scene_message } from './messages';

function pointer_of_failure(parse: () => unknown): string {
  try {
    parse();
  } catch (error) {
    if (error instanceof WireError) return error.pointer;
    throw error;
  }
  throw new Error('the message was accepted');
}

describe('parse_job', () => {
  it('takes what the page needs', () => {
    const plan = { method: 'progressive', biased: false, uses_maps: true, items: [{ feature: 'method', active: true, reason: 'there is glass' }] };
    expect(parse_job(job_message(), '')).toEqual(a_job({ plan: plan as never }));
  });

  it('takes a queued job, which has no plan, error or picture yet', () => {
    const job = parse_job(job_message({ plan: null, error: null, eta_seconds: null, first_frame_seconds: null, revision: 0 }), '');
    expect(job).toMatchObject({ plan: null, error: null, eta_seconds: null, revision: 0 });
  });

  it('takes why a job failed', () => {
    const problem = { code: 'invalid_input', detail: 'too dark', pointer: '' };
    expect(parse_job(job_message({ state: 'failed', problem }), '').failure).toBe('too dark');
  });

  const spec_message = job_message()['spec'] as object;
  it.each([
    ['/state', { state: 'resting' }],
    ['/passes', { passes: '3' }],
    ['/passes', { passes: -1 }],
    ['/version', { version: 1.5 }],
    ['/maps/hits', { maps: { disk_hits: 0, misses: 1 } }],
    ['/error/relative', { error: { relative: 'NaN' } }],
    ['/error', { error: 0.1 }],
    ['/plan/items/0/reason', { plan: { method: 'path', biased: false, uses_maps: false, items: [{ feature: 'x', active: true }] } }],
    ['/plan/method', { plan: { method: 'magic', biased: false, items: [] } }],
    ['/spec', { spec: null }],
    ['/spec/film/width', { spec: { ...spec_message, film: { height: 3 } } }],
    ['/spec/camera', { spec: { ...spec_message, camera: -1 } }],
    ['/spec/camera/up', { spec: { ...spec_message, camera: { eye: [0, 0, 1], target: [0, 0, 0], up: [0, 1], yfov_deg: 40 } } }],
    ['/spec/environment/id', { spec: { ...spec_message, environment: { rotation_deg: 0, scale: 1 } } }],
    ['/spec/seed', { spec: { ...spec_message, seed: 7 } }],
    ['/id', { id: null }],
  ])('names %s where it is malformed', (pointer, changes) => {
    expect(pointer_of_failure(() => parse_job(job_message(changes), ''))).toBe(pointer);
  });

  it.each([[null], [7], ['text'], [[]]])('refuses %j', (value) => {
    expect(pointer_of_failure(() => parse_job(value, ''))).toBe('');
  });
});

describe('parse_report', () => {
  it('takes what the page needs', () => {
    expect(parse_report(scene_message(), '')).toMatchObject({
      name: 'box', triangles: 1204, emissive_triangles: 2, lights: 0, environment: false, materials: 1,
      cameras: [{ name: 'main', eye: [0, 0, 0], direction: [0, 0, -1], yfov_deg: 40 }], size: [2, 2.5, 2], centre: [0, 1.25, 0],
      plan: { method: 'progressive' }, warnings: ['materials[0]: something is ignored'],
    });
  });

  it('takes a scene without extent', () => {
    const report = { ...(scene_message()['report'] as object), bounds: null };
    expect(parse_report(scene_message({ report }), '')).toMatchObject({ size: null, centre: null });
  });

  it('names what is malformed', () => {
    expect(pointer_of_failure(() => parse_report(scene_message({ report: undefined }), ''))).toBe('/report');
    const report = { ...(scene_message()['report'] as object), bounds: { min: [0, 0], max: [1, 1, 1] } };
    expect(pointer_of_failure(() => parse_report(scene_message({ report }), ''))).toBe('/report/bounds/min');
  });

  it('takes lists, where there are no reports', () => {
    const { report: _report, plan: _plan, ...listed } = scene_message();
    expect(parse_scenes({ scenes: [listed], next_cursor: null }, '')).toEqual({
      scenes: [{ id: 'ab'.repeat(32), name: 'box', bytes: 1000, sample: true }], next_cursor: null,
    });
  });
});

describe('the other messages', () => {
  it('names the job of a list that is malformed', () => {
    expect(parse_jobs({ jobs: [job_message()], next_cursor: 'c-1' }, '')).toMatchObject({ jobs: [{ id: 'j-1' }], next_cursor: 'c-1' });
    expect(pointer_of_failure(() => parse_jobs({ jobs: [job_message(), job_message({ id: 1 })] }, ''))).toBe('/jobs/1/id');
  });

  it('takes the version and the limits of the server', () => {
    const info = { name: 'photond', version: '0.1.0', limits: { max_upload_bytes: 100, max_streams: 2 } };
    expect(parse_info(info, '')).toEqual({ version: '0.1.0', limits: { max_upload_bytes: 100 } });
    expect(pointer_of_failure(() => parse_info({ version: '1' }, ''))).toBe('/limits');
  });

  it('takes environments', () => {
    const map = { id: 'cd'.repeat(32), name: 'sky.hdr', media_type: 'image/x-exr', bytes: 9, width: 8, height: 4, warnings: [], created_at: '' };
    expect(parse_environments({ environments: [map] }, '')).toEqual([{ id: map.id, name: 'sky.hdr', width: 8, height: 4 }]);
    expect(pointer_of_failure(() => parse_environments({ environments: [{ ...map, width: '8' }] }, ''))).toBe('/environments/0/width');
  });

  it('takes events', () => {
    expect(parse_event(event_message(), '')).toEqual(an_event());
    expect(pointer_of_failure(() => parse_event(event_message({ job: 1 }), ''))).toBe('/job');
  });

  it('leaves out points of a series without an error', () => {
    const points = [
      { revision: 1, passes: 1, seconds: 0.5, error: null },
      { revision: 2, passes: 2, seconds: 1, error: { relative: 0.5, rmse: 1 } },
    ];
    expect(parse_series({ job: 'j-1', points }, '')).toEqual([{ seconds: 1, error: 0.5 }]);
  });

  it('takes problems with and without details', () => {
    expect(parse_problem({ title: 'Bad', status: 400, detail: 'no', pointer: '/film' }, '')).toEqual({ title: 'Bad', detail: 'no', pointer: '/film' });
    expect(parse_problem({}, '')).toEqual({ title: '', detail: '', pointer: '' });
    expect(pointer_of_failure(() => parse_problem({ detail: [] }, ''))).toBe('/detail');
  });
});

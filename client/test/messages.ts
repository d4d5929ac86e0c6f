import type { Job, JobEvent, JobSpec } from '../src/wire';

/** A job as the server sends it and `read_json` reads it. */
export function job_message(changes: Record<string, unknown> = {}): Record<string, unknown> {
  return {
    id: 'j-1', state: 'rendering', version: 5, label: '', scene: 'ab'.repeat(32),
    spec: {
      scene: 'ab'.repeat(32), environment: null, camera: 0, film: { width: 320, height: 200 }, method: 'auto', photons_per_pass: 1000,
      radius: 0, gather_photons: 64, seed: '0', stop: { passes: 16, seconds: null, relative_error: null },
      priority: 'interactive', label: '',
    },
    created_at: '2026-01-31T12:00:00.123Z', started_at: null, finished_at: null,
    plan: {
      method: 'progressive', biased: false, uses_maps: true, radius: 0.02,
      items: [{ feature: 'method', active: true, reason: 'there is glass' }],
    },
    maps: { hits: 2, disk_hits: 1, misses: 1 }, passes: 3, seconds: 1.5, rejected_samples: 0,
    error: { relative: 0.25, noise: 0.24, bias: 0.07, rmse: 0.1 },
    eta_seconds: 4.5, revision: 2, first_frame_seconds: 0.4, paused_because: null, problem: null,
    urls: { self: '/v1/jobs/j-1' },
    ...changes,
  };
}

/** An event as the server sends it. */
export function event_message(changes: Record<string, unknown> = {}): Record<string, unknown> {
  return {
    job: 'j-1', time: '2026-01-31T12:00:01.000Z', state: 'rendering', version: 6, passes: 4, seconds: 2,
    rejected_samples: 0, error: { relative: 0.2, noise: 0.16, bias: 0.12, rmse: 0.08 }, eta_seconds: 4, maps: { hits: 3, disk_hits: 1, misses: 1 }, revision: 3, ...changes,
  };
}

/** A scene with its report as the server sends it. */
export function scene_message(changes: Record<string, unknown> = {}): Record<string, unknown> {
  return {
    id: 'ab'.repeat(32), name: 'box', sample: true, media_type: 'model/gltf-binary', bytes: 1000,
    created_at: '2026-01-31T12:00:00.123Z', urls: {},
    report: {
      counts: { meshes: 1, triangles: 1204, triangles_stored: 12, emissive_triangles: 2, instances: 1, textures: 0, texture_pixels: 0 },
      bounds: { min: [-1, 0, -1], max: [1, 2.5, 1] }, environment: [0, 0, 0],
      cameras: [{ name: 'main', orthographic: false, yfov_deg: 40, eye: [0, 0, 0], direction: [0, 0, -1], up: [0, 1, 0] }],
      lights: [], materials: [{ name: 'white', kind: 'diffuse', emissive: false, textured: false }],
      warnings: ['materials[0]: something is ignored'],
    },
    plan: { method: 'progressive', biased: false, uses_maps: true, radius: 0.1, items: [] },
    ...changes,
  };
}

export function a_spec(changes: Partial<JobSpec> = {}): JobSpec {
  return {
    environment: null, camera: 0, film: { width: 320, height: 200 }, method: 'auto', photons_per_pass: 1000, radius: 0,
    gather_photons: 64, seed: '0', stop: { passes: 16, seconds: null, relative_error: null }, priority: 'interactive',
    ...changes,
  };
}

export function a_job(changes: Partial<Job> = {}): Job {
  return {
    id: 'j-1', created_at: '2026-01-31T12:00:00.123Z', scene: 'ab'.repeat(32), label: '', state: 'rendering', version: 5,
    spec: a_spec(), plan: null, passes: 3, seconds: 1.5,
    rejected_samples: 0, error: 0.25, noise: 0.24, bias: 0.07, eta_seconds: 4.5, map_hits: 2, map_disk_hits: 1, map_misses: 1, revision: 2, first_frame_seconds: 0.4, paused_because: null, failure: null,
    ...changes,
  };
}

export function an_event(changes: Partial<JobEvent> = {}): JobEvent {
  return {
    job: 'j-1', state: 'rendering', version: 6, passes: 4, seconds: 2, rejected_samples: 0, error: 0.2,
    noise: 0.16, bias: 0.12, eta_seconds: 4, map_hits: 3, map_disk_hits: 1, map_misses: 1, revision: 3, ...changes,
  };
}

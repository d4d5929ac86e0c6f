import { afterEach, beforeEach, describe, expect, it, vi } from 'vitest';
import type { Answer, Failure } from '../src/api';
import { Steering } from '../src/steering';
import type { Job, JobRequest, Placement } from '../src/wire';
import { a_job, a_spec } from './messages';

const place = (x: number): Placement => ({ eye: [x, 0, 4], target: [0, 0, 0], yfov_deg: 40 });
const turns = async () => { for (let i = 0; i < 20; ++i) await Promise.resolve(); };

/** A page and a server that note what is asked of them. */
class Desk {
  watched: Job | null = a_job({ id: 'first' });
  readonly requests: JobRequest[] = [];
  readonly log: string[] = [];
  readonly failures: Failure[] = [];
  answer: ((request: JobRequest) => Answer<Job>) | null = null;
  readonly steering = new Steering({
    watched: () => this.watched,
    submit: async (request) => {
      this.requests.push(request);
      if (this.answer) return this.answer(request);
      const job = a_job({ id: `s${this.requests.length}`, spec: a_spec({ camera: request.camera! }), state: 'queued', revision: 0 });
      return { ok: true, value: job };
    },
    cancel: async (id) => {
      this.log.push(`cancel ${id}`);
      return { ok: true, value: a_job({ id, state: 'canceling' }) };
    },
    pause: async (id) => this.log.push(`pause ${id}`),
    remove: async (id) => this.log.push(`remove ${id}`),
    succeed: (job, stays) => {
      this.log.push(`${job.id}${stays ? ', back leads to the one before' : ''}`);
      this.watched = job;
    },
    forget: (id) => this.log.push(`forget ${id}`),
    fail: (failure) => this.failures.push(failure),
  });
}

describe('steering', () => {
  beforeEach(() => { vi.useFakeTimers(); });
  afterEach(() => { vi.useRealTimers(); });

  it('starts a job like the one that is watched', async () => {
    const desk = new Desk();
    const seed = '18446744073709551615';
    const stop = { passes: null, seconds: 9, relative_error: null };
    desk.watched = a_job({ label: 'mine', spec: a_spec({ seed, stop }) });
    desk.steering.look(place(1));
    await turns();
    expect(desk.requests).toMatchObject([{ scene: desk.watched.scene, label: 'mine', seed, camera: place(1) }]);
    expect(desk.requests[0]?.stop).toEqual({ seconds: 9 });
    expect(desk.log).toEqual(['s1, back leads to the one before']);
  });

  it('remembers only the newest place until there is a picture', async () => {
    const desk = new Desk();
    for (const x of [1, 2, 3]) desk.steering.look(place(x));
    await turns();
    expect(desk.requests).toHaveLength(1);
    desk.steering.look(place(4));
    expect(desk.steering.next()).toEqual(place(4));
    desk.steering.arrived('another');
    await turns();
    expect(desk.requests).toHaveLength(1);
    desk.steering.arrived('s1');
    await turns();
    expect(desk.requests.map(({ camera }) => camera)).toEqual([place(1), place(4)]);
    expect(desk.steering.next()).toEqual(place(4));   // further steps go on from there
    desk.steering.arrived('s2');
    await turns();
    expect(desk.steering.next()).toBeNull();
  });

  it('ends and removes what was left on the way, but not where it began', async () => {
    const desk = new Desk();
    desk.steering.look(place(1));
    await turns();
    desk.steering.look(place(2));
    desk.steering.arrived('s1');
    await turns();
    expect(desk.log).toEqual(['s1, back leads to the one before', 's2', 'forget s1', 'cancel s1']);
    expect(desk.steering.has_left({ id: 's1', state: 'canceling' })).toBe(true);
    expect(desk.steering.has_left({ id: 's1', state: 'canceled' })).toBe(true);
    expect(desk.steering.has_left({ id: 's2', state: 'rendering' })).toBe(false);
    expect(desk.steering.has_left({ id: 's1', state: 'canceled' })).toBe(true);
    expect(desk.log.filter((entry) => entry.startsWith('remove'))).toEqual(['remove s1']);
  });

  it('lets a job rest that was started here', async () => {
    const desk = new Desk();
    desk.steering.begin('first');
    desk.steering.look(place(1));
    await turns();
    expect(desk.log).toEqual(['s1, back leads to the one before', 'pause first']);
    desk.watched = a_job({ id: 'done', state: 'succeeded' });
    desk.steering.begin('done');
    desk.steering.arrived('s1');
    await turns();
    desk.steering.look(place(2));
    await turns();
    expect(desk.log.slice(2)).toEqual(['s2, back leads to the one before']);
  });

  it('keeps what was finished', async () => {
    const desk = new Desk();
    desk.steering.look(place(1));
    await turns();
    desk.steering.arrived('s1');
    await turns();
    vi.advanceTimersByTime(1000);
    desk.watched = { ...desk.watched!, state: 'succeeded' };
    desk.steering.look(place(2));
    await turns();
    expect(desk.log).toEqual(['s1, back leads to the one before', 's2, back leads to the one before']);
  });

  it('removes what was finished before somebody rested there', async () => {
    const desk = new Desk();
    desk.steering.look(place(1));
    await turns();
    desk.steering.arrived('s1');
    await turns();
    vi.advanceTimersByTime(900);
    desk.watched = { ...desk.watched!, state: 'succeeded' };
    desk.steering.look(place(2));
    await turns();
    expect(desk.log).toEqual(['s1, back leads to the one before', 's2', 'forget s1', 'remove s1']);
  });

  it('lets rest what took long', async () => {
    const desk = new Desk();
    desk.steering.look(place(1));
    await turns();
    desk.steering.arrived('s1');
    await turns();
    vi.advanceTimersByTime(60_000);
    desk.watched = { ...desk.watched!, seconds: 60 };
    desk.steering.look(place(2));
    await turns();
    expect(desk.log).toEqual(['s1, back leads to the one before', 's2, back leads to the one before', 'pause s1']);
  });

  it('leads nobody away from what he looks at since', async () => {
    const desk = new Desk();
    desk.steering.look(place(1));
    await turns();
    desk.steering.look(place(2));
    desk.watched = a_job({ id: 'another' });
    desk.steering.stop();
    await turns();
    expect(desk.steering.next()).toBeNull();
    expect(desk.requests).toHaveLength(1);
    desk.steering.look(place(3));
    desk.watched = a_job({ id: 'first' });
    desk.steering.stop();
    await turns();   // the job was started meanwhile
    expect(desk.log).toEqual(['s1, back leads to the one before', 'forget s2', 'cancel s2']);
    expect(desk.watched.id).toBe('first');
  });

  it('says why a place cannot be had, and goes on from the next', async () => {
    const desk = new Desk();
    desk.answer = () => ({ ok: false, failure: { kind: 'away' } });
    desk.steering.look(place(1));
    await turns();
    expect(desk.failures).toEqual([{ kind: 'away' }]);
    expect(desk.steering.next()).toBeNull();
    desk.answer = null;
    for (const x of [3, 2]) desk.steering.look(place(x));
    await turns();
    expect(desk.requests).toHaveLength(1);   // a drag goes on, but does not ask again and again
    vi.advanceTimersByTime(1000);
    await turns();
    expect(desk.requests.slice(1)).toMatchObject([{ camera: place(2) }]);
    expect(desk.log).toEqual(['s2, back leads to the one before']);
  });
});

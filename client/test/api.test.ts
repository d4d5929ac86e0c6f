import { afterEach, describe, expect, it, vi } from 'vitest';
import { api, fetch_file, load_frame } from '../src/api';
import type { View } from '../src/frames';
import { job_message } from './messages';

afterEach(() => void vi.unstubAllGlobals());

/** Answers requests by what `answer` makes of their address; returns the addresses that were asked for. */
function server(answer: (url: URL) => Response): string[] {
  const asked: string[] = [];
  vi.stubGlobal('fetch', async (path: string) => {
    asked.push(path);
    return answer(new URL(path, 'http://photond/'));
  });
  return asked;
}

const page = (ids: string[], next_cursor: string | null) =>
  Response.json({ scenes: ids.map((id) => ({ id, name: '', bytes: 1, sample: false })), next_cursor });

describe('the list of scenes', () => {
  it('is followed from page to page', async () => {
    const pages: Record<string, Response> = { '': page(['a', 'b'], 'c-1'), 'c-1': page(['c'], 'c-2'), 'c-2': page(['d'], null) };
    server((url) => pages[url.searchParams.get('cursor') ?? '']!);
    const answer = await api.scenes();
    expect(answer.ok && answer.value.map(({ id }) => id)).toEqual(['a', 'b', 'c', 'd']);
  });

  it('ends somewhere, though the server always knows of more', async () => {
    const asked = server(() => page(['a'], 'c-1'));
    expect(await api.scenes()).toMatchObject({ ok: true });
    expect(asked.length).toBeLessThanOrEqual(10);
  });

  it('fails where one of its pages does', async () => {
    server((url) => (url.searchParams.has('cursor') ? new Response('', { status: 503 }) : page(['a'], 'c-1')));
    expect(await api.scenes()).toMatchObject({ ok: false, failure: { status: 503 } });
  });
});

describe('a seed', () => {
  it('is asked for again to the last digit', async () => {
    const text = JSON.stringify(job_message()).replace('"seed":"0"', '"seed":18446744073709551615');
    const sent: unknown[] = [];
    vi.stubGlobal('fetch', async (_path: string, init: RequestInit) => {
      sent.push(init.body);
      return new Response(text);
    });
    const job = await api.job('j-1');
    if (!job.ok) throw new Error('no job');
    await api.submit({ scene: 'a', seed: job.value.spec.seed, stop: {} });
    expect(sent[1]).toContain('"seed":18446744073709551615,');
  });
});

describe('a picture', () => {
  const load = (view: View = 'picture') =>
    load_frame({ job: 'j-1', view, revision: 1, lossless: true }, new AbortController().signal);

  it('is to be asked for later where the server is busy or away', async () => {
    for (const status of [429, 500, 503]) {
      server(() => new Response('', { status }));
      expect(await load()).toBe('later');
    }
    server(() => { throw new TypeError('no connection'); });
    expect(await load()).toBe('later');
  });

  it('is to be asked for later where it arrives broken', async () => {
    vi.stubGlobal('createImageBitmap', () => Promise.reject(new DOMException('no picture', 'InvalidStateError')));
    server(() => new Response('half a picture'));
    expect(await load()).toBe('later');
  });

  it('comes with the revision that it is of, and so does its error', async () => {
    vi.stubGlobal('createImageBitmap', async () => 'pixels');
    for (const [view, layer] of [['picture', ''], ['error', '?layer=error.bound']] as const) {
      const asked = server(() => new Response('', { headers: { 'Content-Location': `/v1/jobs/j-1/frames/7.png${layer}` } }));
      expect(await load(view)).toEqual({ bitmap: 'pixels', revision: 7 });
      expect(asked).toEqual([`v1/jobs/j-1/frames/latest.png${layer}`]);
    }
  });

  it('is not to be asked for again where there is none', async () => {
    for (const status of [204, 401, 404]) {
      server(() => new Response(null, { status }));
      expect(await load()).toBeNull();
    }
  });
});

describe('a file', () => {
  it('is had by 200 alone, not by an answer without one', async () => {
    server(() => new Response('pixels'));
    const file = await fetch_file('v1/jobs/j-1/frames/latest.png');
    expect(file.ok && await file.value.text()).toBe('pixels');
    server(() => new Response(null, { status: 204 }));
    expect(await fetch_file('a')).toMatchObject({ ok: false, failure: { kind: 'problem', status: 204 } });
    server(() => Response.json({ title: 'busy' }, { status: 503 }));
    expect(await fetch_file('a')).toMatchObject({ ok: false, failure: { status: 503, problem: { title: 'busy' } } });
    server(() => { throw new TypeError('no connection'); });
    expect(await fetch_file('a')).toEqual({ ok: false, failure: { kind: 'away' } });
  });
});

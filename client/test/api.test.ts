import { afterEach, describe, expect, it, vi } from 'vitest';
import { api } from '../src/api';

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

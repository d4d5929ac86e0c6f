import { createServer, type IncomingMessage, type Server, type ServerResponse } from 'node:http';
import type { AddressInfo } from 'node:net';
import { afterEach, describe, expect, it } from 'vitest';
import { follow, retry_wait } from '../src/events';

let server: Server | null = null;
let stop = () => {};

afterEach(() => {
  stop();
  server?.closeAllConnections();
  server?.close();
});

/** Answers the n-th request by the n-th of `answers`, and further ones by the last; resolves to the address. */
async function serve(...answers: ((request: IncomingMessage, response: ServerResponse) => void)[]): Promise<string> {
  let count = 0;
  server = createServer((request, response) => answers[Math.min(count++, answers.length - 1)]!(request, response));
  await new Promise<void>((done) => server!.listen(0, '127.0.0.1', done));
  return `http://127.0.0.1:${(server.address() as AddressInfo).port}/`;
}

/** Follows `url` until `enough` of the noted happenings are there. */
function happenings(url: string, enough: number): Promise<string[]> {
  const noted: string[] = [];
  return new Promise((resolve) => {
    const note = (text: string) => {
      noted.push(text);
      if (noted.length === enough) resolve(noted);
    };
    ({ stop } = follow(url, {
      on_open: () => note('open'),
      on_message: (message) => note(message.data),
      on_lost: () => note('lost'),
      on_locked: () => note('locked'),
    }));
  });
}

const begin = (response: ServerResponse, text: string) => {
  response.writeHead(200, { 'Content-Type': 'text/event-stream' });
  response.write(text);
};

describe('follow', () => {
  it('connects again after a loss and says what it has seen last', async () => {
    let seen: unknown;
    const url = await serve(
      (_, response) => { begin(response, 'id: 41\ndata: one\n\nid: 42\ndata: half'); setTimeout(() => response.destroy(), 50); },
      (request, response) => { seen = request.headers['last-event-id']; begin(response, 'id: 42\ndata: two\n\n'); });
    expect(await happenings(url, 5)).toEqual(['open', 'one', 'lost', 'open', 'two']);
    expect(seen).toBe('41');
  });

  it('tries again while it is refused', async () => {
    const url = await serve(
      (_, response) => { response.writeHead(503); response.end('{}'); },
      (_, response) => begin(response, 'data: at last\n\n'));
    expect(await happenings(url, 3)).toEqual(['lost', 'open', 'at last']);
  });

  it('asks no more where a key is needed', async () => {
    let asked = 0;
    const url = await serve((_, response) => { ++asked; response.writeHead(401); response.end('{}'); });
    expect(await happenings(url, 1)).toEqual(['locked']);
    await new Promise((done) => setTimeout(done, 700));
    expect(asked).toBe(1);
  });

  it('is silent once it is stopped', async () => {
    const noted: string[] = [];
    const url = await serve((_, response) => begin(response, 'data: one\n\n'));
    const stream = follow(url, {
      on_open: () => noted.push('open'), on_lost: () => noted.push('lost'), on_locked: () => noted.push('locked'),
      on_message: (message) => { noted.push(message.data); stream.stop(); },
    });
    await new Promise((done) => setTimeout(done, 300));
    expect(noted).toEqual(['open', 'one']);
  });
});

describe('retry_wait', () => {
  it('doubles up to ten seconds', () => {
    expect([0, 1, 2, 3, 4, 5, 9].map((attempt) => retry_wait(attempt, null))).toEqual([500, 1000, 2000, 4000, 8000, 10000, 10000]);
    expect(retry_wait(0, 2000)).toBe(2000);
    expect(retry_wait(0, 1e9)).toBe(10000);
  });
});

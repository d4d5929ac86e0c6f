import { fetch_with_key } from './key';
import { SseParser, type SseMessage } from './sse';

const kSilenceMs = 40_000; // the server's heartbeat comes every 15 s
const kFirstWaitMs = 500;
const kLongestWaitMs = 10_000;

export interface StreamHandlers {
  on_message(message: SseMessage): void;
  on_open(): void;
  /** There is no stream, or it broke; it is tried again after `wait_ms`. */
  on_lost(wait_ms: number): void;
  /** The server asks for another key (see key.ts): nothing is tried again. */
  on_locked(): void;
}

/** The wait before connection attempt `attempt` (from 0) after a loss: doubling, with a cap. */
export function retry_wait(attempt: number, asked_ms: number | null): number {
  return Math.min(kLongestWaitMs, Math.max(asked_ms ?? 0, kFirstWaitMs) * 2 ** attempt);
}

/**
 * Follows an event stream until `stop` is called: connects, hands on each message, and after a loss connects again
 * with Last-Event-ID, so that the server repeats what was missed. Ends where the server asks for a key.
 */
export function follow(url: string, handlers: StreamHandlers): { stop(): void } {
  const ended = new AbortController();
  void run(url, handlers, ended.signal);
  return { stop: () => ended.abort() };
}

async function run(url: string, handlers: StreamHandlers, ended: AbortSignal): Promise<void> {
  let last_id = '';
  let asked_ms: number | null = null;
  for (let attempt = 0; !ended.aborted; ++attempt) {
    const parser = new SseParser(last_id);
    const outcome = await connect(url, parser, handlers, ended);
    if (ended.aborted) return;
    if (outcome === 'locked') return handlers.on_locked();
    last_id = parser.last_id;
    asked_ms = parser.retry_ms ?? asked_ms;
    if (outcome === 'opened') attempt = 0;
    const wait = retry_wait(attempt, asked_ms);
    handlers.on_lost(wait);
    await pause(wait, ended);
  }
}

/** One connection, from request to end. */
async function connect(
  url: string, parser: SseParser, handlers: StreamHandlers, ended: AbortSignal,
): Promise<'opened' | 'refused' | 'locked'> {
  const silence = new AbortController();
  const give_up = () => silence.abort();
  let timer = setTimeout(give_up, kSilenceMs);
  ended.addEventListener('abort', give_up);
  try {
    const headers: Record<string, string> = { Accept: 'text/event-stream' };
    if (parser.last_id) headers['Last-Event-ID'] = parser.last_id;
    const response = await reached(fetch_with_key(url, { headers, cache: 'no-store', signal: silence.signal }));
    if (response?.status === 401) return 'locked';
    if (!response?.ok || !response.body) return 'refused';
    if (!ended.aborted) handlers.on_open();
    const reader = response.body.getReader();
    const decoder = new TextDecoder();
    for (;;) {
      const part = await reached(reader.read());
      if (!part || part.done || ended.aborted) return 'opened';
      clearTimeout(timer);
      timer = setTimeout(give_up, kSilenceMs);
      for (const message of parser.push(decoder.decode(part.value, { stream: true }))) {
        if (!ended.aborted) handlers.on_message(message);
      }
    }
  } finally {
    clearTimeout(timer);
    ended.removeEventListener('abort', give_up);
  }
}

/** The value of a fetch or read; null where it failed for reasons outside of this page (no connection, an abort). */
export async function reached<T>(attempt: Promise<T>): Promise<T | null> {
  try {
    return await attempt;
  } catch (error) {
    if (error instanceof TypeError || (error instanceof DOMException && error.name === 'AbortError')) return null;
    throw error;
  }
}

function pause(ms: number, ended: AbortSignal): Promise<void> {
  return new Promise((resolve) => {
    const timer = setTimeout(resolve, ms);
    ended.addEventListener('abort', () => { clearTimeout(timer); resolve(); }, { once: true });
  });
}

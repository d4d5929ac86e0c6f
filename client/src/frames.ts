import type { FramePicture } from './api';
import { retry_wait } from './events';

const kFirstWaitMs = 1000; // before a picture that could not be had is asked for again

/** What is shown of a job: its picture, or how wrong each pixel of it may be. */
export type View = 'picture' | 'error';

/** What is looked at. */
export interface Watched {
  job: string;
  view: View;
}

/** Names one picture: a revision of a job's. */
export interface FrameKey extends Watched {
  revision: number;
  /** Fetched without loss; a better form of the same revision. */
  lossless: boolean;
}

/** Whether both are of one job and show the same of it. */
export function same(a: Watched | null, b: Watched | null): boolean {
  return a?.job === b?.job && a?.view === b?.view;
}

/** Whether `candidate` should replace `shown`: never a picture of something else than is watched, or an older one. */
export function supersedes(candidate: FrameKey, shown: FrameKey | null, watched: Watched | null): boolean {
  if (!same(candidate, watched)) return false;
  if (!shown || !same(shown, watched)) return true;
  if (candidate.revision !== shown.revision) return candidate.revision > shown.revision;
  return candidate.lossless && !shown.lossless;
}

type Load = (key: FrameKey, signal: AbortSignal) => Promise<FramePicture | 'later' | null>;

/**
 * Fetches the pictures that are announced, one at a time: while one is on its way only the newest announcement is
 * remembered, so that a slow line skips pictures. What arrives late, of something else or of an older revision, is dropped.
 * What cannot be had just now is asked for again: of a job that has ended nothing else is announced.
 */
export class FrameLoader {
  private watched: Watched | null = null;
  private shown: FrameKey | null = null;
  private loading: { key: FrameKey; abort: AbortController } | null = null;
  private next: FrameKey | null = null;
  /** How often in a row the server put us off, and the timer of the next try. */
  private put_off = 0;
  private retry: ReturnType<typeof setTimeout> | undefined;

  /** `load` answers null where there is no picture, 'later' where one may be had; `show` receives those that count. */
  constructor(private readonly load: Load, private readonly show: (picture: FramePicture, key: FrameKey) => void) {}

  /** From now on only such pictures count. */
  watch(watched: Watched | null): void {
    if (same(watched, this.watched)) return;
    this.watched = watched;
    this.shown = null;
    this.next = null;
    this.put_off = 0;
    this.loading?.abort.abort();
    this.loading = null;
  }

  /** There is such a picture. */
  announce(key: FrameKey): void {
    if (!supersedes(key, this.shown, this.watched)) return;
    if (this.loading && !supersedes(key, this.loading.key, this.watched)) return;
    if (this.next && !supersedes(key, this.next, this.watched)) return;
    this.next = key;
    if (!this.loading) void this.run();
  }

  private async run(): Promise<void> {
    while (this.next) {
      const loading = { key: this.next, abort: new AbortController() };
      this.loading = loading;
      this.next = null;
      const picture = await this.load(loading.key, loading.abort.signal);
      if (this.loading !== loading) return discard(picture); // something else is watched since
      this.loading = null;
      if (picture === 'later') this.try_later(loading.key);
      else if (picture) this.accept(picture, { ...loading.key, revision: picture.revision });
    }
  }

  /** Announces it again after a while: by then it may not count any more. */
  private try_later(key: FrameKey): void {
    clearTimeout(this.retry);
    this.retry = setTimeout(() => this.announce(key), retry_wait(this.put_off++, kFirstWaitMs));
  }

  private accept(picture: FramePicture, key: FrameKey): void {
    if (!supersedes(key, this.shown, this.watched)) return discard(picture);
    this.shown = key;
    this.put_off = 0;
    this.show(picture, key);
    if (this.next && !supersedes(this.next, this.shown, this.watched)) this.next = null;
  }
}

/** Lets go of the pixels, which may be tens of megabytes, without waiting for the garbage collector. */
function discard(picture: FramePicture | 'later' | null): void {
  if (picture && picture !== 'later') picture.bitmap.close();
}

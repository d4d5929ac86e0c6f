import { afterEach, beforeEach, describe, expect, it, vi } from 'vitest';
import type { FramePicture } from '../src/api';
import { FrameLoader, supersedes, type FrameKey, type Watched } from '../src/frames';

const picture_of = (job: string): Watched => ({ job, view: 'picture' });
const error_of = (job: string): Watched => ({ job, view: 'error' });
const key = (job: string, revision: number, lossless = false): FrameKey => ({ ...picture_of(job), revision, lossless });

beforeEach(() => void vi.useFakeTimers());
afterEach(() => void vi.useRealTimers());

/** A loader whose fetches are answered by hand. */
function bench() {
  type Answer = FramePicture | 'later' | null;
  const asked: { key: FrameKey; signal: AbortSignal; answer(picture: Answer): Promise<void> }[] = [];
  const shown: FrameKey[] = [];
  const loader = new FrameLoader(
    (wanted, signal) => new Promise((resolve) => {
      const answer = async (picture: Answer) => {
        resolve(picture);
        await vi.advanceTimersByTimeAsync(0);
      };
      asked.push({ key: wanted, signal, answer });
    }),
    (_picture, found) => shown.push(found));
  return { loader, asked, shown };
}

const picture = (revision: number) => ({ revision, bitmap: { close: vi.fn() as () => void } as ImageBitmap });

describe('supersedes', () => {
  it('prefers newer revisions, then lossless ones, of the watched job only', () => {
    expect(supersedes(key('a', 1), null, picture_of('a'))).toBe(true);
    expect(supersedes(key('a', 1), null, picture_of('b'))).toBe(false);
    expect(supersedes(key('a', 2), key('a', 1), picture_of('a'))).toBe(true);
    expect(supersedes(key('a', 1), key('a', 2), picture_of('a'))).toBe(false);
    expect(supersedes(key('a', 2), key('a', 2), picture_of('a'))).toBe(false);
    expect(supersedes(key('a', 2, true), key('a', 2), picture_of('a'))).toBe(true);
    expect(supersedes(key('a', 2), key('a', 2, true), picture_of('a'))).toBe(false);
    expect(supersedes(key('a', 1), key('b', 7), picture_of('a'))).toBe(true);
  });

  it('takes pictures and errors apart', () => {
    const error = { ...error_of('a'), revision: 1, lossless: false };
    expect(supersedes(error, key('a', 7, true), error_of('a'))).toBe(true);
    expect(supersedes(error, null, picture_of('a'))).toBe(false);
    expect(supersedes(key('a', 7), error, error_of('a'))).toBe(false);
  });
});

describe('FrameLoader', () => {
  it('fetches one at a time, and of those announced meanwhile only the newest', async () => {
    const { loader, asked, shown } = bench();
    loader.watch(picture_of('a'));
    for (const revision of [1, 2, 3, 2]) loader.announce(key('a', revision));
    expect(asked.map((fetch) => fetch.key.revision)).toEqual([1]);
    await asked[0]!.answer(picture(1));
    expect(asked.map((fetch) => fetch.key.revision)).toEqual([1, 3]);
    await asked[1]!.answer(picture(3));
    expect(shown.map((found) => found.revision)).toEqual([1, 3]);
    expect(asked).toHaveLength(2);
  });

  it('drops what arrives after another job is watched', async () => {
    const { loader, asked, shown } = bench();
    loader.watch(picture_of('a'));
    loader.announce(key('a', 5));
    loader.watch(picture_of('b'));
    loader.announce(key('b', 1));
    expect(asked[0]!.signal.aborted).toBe(true);
    await asked[1]!.answer(picture(1));
    await asked[0]!.answer(picture(5));
    expect(shown).toEqual([key('b', 1)]);
  });

  it('drops a picture that arrives after the error is looked at, and shows the error of the same revision', async () => {
    const { loader, asked, shown } = bench();
    loader.watch(picture_of('a'));
    loader.announce(key('a', 5));
    loader.watch(error_of('a'));
    const error = { ...error_of('a'), revision: 5, lossless: false };
    loader.announce(error);
    expect(asked[0]!.signal.aborted).toBe(true);
    await asked[0]!.answer(picture(5));
    await asked[1]!.answer(picture(5));
    expect(shown).toEqual([error]);
  });

  it('drops a late picture of a job that is watched again', async () => {
    const { loader, asked, shown } = bench();
    loader.watch(picture_of('a'));
    loader.announce(key('a', 1));
    loader.watch(picture_of('b'));
    loader.watch(picture_of('a'));
    loader.announce(key('a', 2));
    await asked[1]!.answer(picture(2));
    await asked[0]!.answer(picture(1));
    expect(shown).toEqual([key('a', 2)]);
  });

  it('lets go of the pixels that are not shown', async () => {
    const { loader, asked, shown } = bench();
    const [for_another, older, wanted] = [picture(5), picture(1), picture(2)];
    loader.watch(picture_of('a'));
    loader.announce(key('a', 5));
    loader.watch(picture_of('b'));
    await asked[0]!.answer(for_another);
    loader.announce(key('b', 2));
    await asked[1]!.answer(wanted);
    loader.announce(key('b', 3));
    await asked[2]!.answer(older);
    expect(shown).toEqual([key('b', 2)]);
    expect(for_another.bitmap.close).toHaveBeenCalledOnce();
    expect(older.bitmap.close).toHaveBeenCalledOnce();
    expect(wanted.bitmap.close).not.toHaveBeenCalled(); // who shows it does so
  });

  it('does not fetch again what a newer answer has overtaken', async () => {
    const { loader, asked, shown } = bench();
    loader.watch(picture_of('a'));
    loader.announce(key('a', 1));
    loader.announce(key('a', 3));
    await asked[0]!.answer(picture(4)); // revision 1 was not kept, the newest came instead
    expect(shown).toEqual([key('a', 4)]);
    expect(asked).toHaveLength(1);
  });

  it('goes on after a picture that could not be had', async () => {
    const { loader, asked, shown } = bench();
    loader.watch(picture_of('a'));
    loader.announce(key('a', 1));
    await asked[0]!.answer(null);
    loader.announce(key('a', 1));
    await asked[1]!.answer(picture(1));
    loader.announce(key('a', 1, true));
    await asked[2]!.answer(picture(1));
    expect(shown).toEqual([key('a', 1), key('a', 1, true)]);
  });

  it('asks again, ever less often, for what cannot be had just now', async () => {
    const { loader, asked, shown } = bench();
    loader.watch(picture_of('a'));
    loader.announce(key('a', 1, true));
    for (const seconds of [1, 2, 4, 8, 10, 10]) {
      const tries = asked.length;
      await asked.at(-1)!.answer('later');
      await vi.advanceTimersByTimeAsync(1000 * seconds - 1);
      expect(asked).toHaveLength(tries);
      await vi.advanceTimersByTimeAsync(1);
      expect(asked).toHaveLength(tries + 1);
    }
    await asked.at(-1)!.answer(picture(1));
    expect(shown).toEqual([key('a', 1, true)]);
    await vi.advanceTimersByTimeAsync(60_000);
    expect(asked).toHaveLength(7);
  });

  it('asks once again though several could not be had, and soon after it went well', async () => {
    const { loader, asked, shown } = bench();
    loader.watch(picture_of('a'));
    loader.announce(key('a', 1));
    await asked[0]!.answer('later');
    loader.announce(key('a', 2));
    await asked[1]!.answer('later');
    await vi.advanceTimersByTimeAsync(2000);
    expect(asked.map((fetch) => fetch.key.revision)).toEqual([1, 2, 2]);
    await asked[2]!.answer(picture(2));
    loader.announce(key('a', 3));
    await asked[3]!.answer('later');
    await vi.advanceTimersByTimeAsync(1000);
    await asked[4]!.answer(picture(3));
    expect(shown.map((found) => found.revision)).toEqual([2, 3]);
  });

  it('does not ask again for a job that nobody watches, nor for what there is not', async () => {
    const { loader, asked } = bench();
    loader.watch(picture_of('a'));
    loader.announce(key('a', 1));
    await asked[0]!.answer(null);
    loader.announce(key('a', 1));
    await asked[1]!.answer('later');
    loader.watch(picture_of('b'));
    await vi.advanceTimersByTimeAsync(60_000);
    expect(asked).toHaveLength(2);
  });
});

import type { Answer, Failure } from './api';
import { is_terminal, type Job, type JobRequest, type Placement } from './wire';

const kMostWaitMs = 3000; // for a first picture while another place is wanted already

/** What steering needs of the page and of the server. */
export interface Steered {
  watched(): Job | null;
  submit(request: JobRequest): Promise<Answer<Job>>;
  cancel(id: string): Promise<Answer<Job>>;
  pause(id: string): Promise<unknown>;
  remove(id: string): Promise<unknown>;
  /** Shows `job` in the place of the one before, which a step back leads to again if it `stays`. */
  succeed(job: Job, stays: boolean): void;
  /** The job is no longer to be seen. */
  forget(id: string): void;
  fail(failure: Failure): void;
}

/**
 * Lets a picture be looked at from elsewhere: each place is a job like the one before, which finds its photon maps in the
 * cache. While one waits for its first picture only the newest place is remembered. Jobs that were left on the way are
 * ended and removed; those that were finished stay, and so does the one that it began with, which rests where it was
 * started here.
 */
export class Steering {
  /** Where nothing leads yet. */
  private wanted: Placement | null = null;
  /** Where everything leads that is under way; null: nothing is. */
  private newest: Placement | null = null;
  /** Jobs that were started here, and those of them that are places on the way. */
  private readonly own = new Set<string>();
  private readonly steps = new Set<string>();
  private readonly left = new Set<string>();
  private readonly removed = new Set<string>();
  private waiting: { job: string; go_on: () => void } | null = null;

  constructor(private readonly steered: Steered) {}

  /** Where the picture is taken from soon, or null: from where it is. */
  next(): Placement | null {
    return this.newest;
  }

  /** A job was started here. */
  begin(job: string): void {
    this.own.add(job);
  }

  look(from: Placement): void {
    const busy = this.newest !== null;
    this.wanted = this.newest = from;
    if (!busy) void this.run();
  }

  /** There is a picture of `job`, or it has ended. */
  arrived(job: string): void {
    if (this.waiting?.job === job) this.waiting.go_on();
  }

  /** Whether `job` was left on the way: nobody wants to hear of it. One that has ended is removed. */
  has_left({ id, state }: Pick<Job, 'id' | 'state'>): boolean {
    if (!this.left.has(id)) return false;
    if (is_terminal(state) && !this.removed.has(id)) {
      this.removed.add(id);
      void this.steered.remove(id);
    }
    return true;
  }

  private async run(): Promise<void> {
    while (this.wanted) {
      const from = this.wanted;
      this.wanted = null;
      await this.step(from);
    }
    this.newest = null;
  }

  private async step(from: Placement): Promise<void> {
    const before = this.steered.watched();
    if (!before) return;
    const answer = await this.steered.submit(request_like(before, from));
    if (!answer.ok) return this.steered.fail(answer.failure);
    const job = answer.value;
    const unfinished = this.own.has(before.id) && this.is_unfinished(before.id);
    const leaves = unfinished && this.steps.has(before.id);
    this.own.add(job.id);
    this.steps.add(job.id);
    const shown = this.first_picture(job.id);
    this.steered.succeed(job, !leaves);
    if (leaves) void this.leave(before.id);
    else if (unfinished) void this.steered.pause(before.id);
    await shown;
  }

  private is_unfinished(id: string): boolean {
    const now = this.steered.watched();
    return now?.id === id && !is_terminal(now.state);
  }

  private async leave(id: string): Promise<void> {
    this.left.add(id);
    this.steered.forget(id);
    const answer = await this.steered.cancel(id);
    if (answer.ok) this.has_left(answer.value);
  }

  private first_picture(job: string): Promise<void> {
    return new Promise((resolve) => {
      const late = setTimeout(resolve, kMostWaitMs);
      this.waiting = { job, go_on: () => { clearTimeout(late); resolve(); } };
    });
  }
}

/** What starts a job like `job` that is seen from elsewhere. */
function request_like({ scene, label, spec }: Job, camera: Placement): JobRequest {
  const { passes, seconds, relative_error } = spec.stop;
  const stop: JobRequest['stop'] = {
    ...(passes !== null && { passes }), ...(seconds !== null && { seconds }),
    ...(relative_error !== null && { relative_error }),
  };
  return { ...spec, scene, label, camera, stop };
}

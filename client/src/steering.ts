import type { Answer, Failure } from './api';
import { is_terminal, type Job, type JobRequest, type Placement } from './wire';

const kMostWaitMs = 10_000; // for a first picture while another place is wanted already
const kRefusedMs = 1000; // before another place is asked for than one that was refused
const kRestMs = 1000; // at a picture: who goes on sooner was on the way
const kKeptSeconds = 10; // of computing: what took as long is not thrown away

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
 * Lets a picture be looked at from elsewhere: each place is a job like the one before, and finds its photon maps in the
 * cache. While one waits for its first picture only the newest place is remembered. Jobs that were left on the way are
 * ended and removed. Where somebody rested and the job was finished or took long, it stays, and so does the one that it
 * began with; of these what was started here and is not finished is paused.
 */
export class Steering {
  private running = false;
  /** Where nothing leads yet. */
  private wanted: Placement | null = null;
  /** Where everything leads that is under way; null: nothing is. */
  private newest: Placement | null = null;
  /** Jobs that were started here, and those of them that are places on the way. */
  private readonly own = new Set<string>();
  private readonly steps = new Set<string>();
  private readonly left = new Set<string>();
  private readonly removed = new Set<string>();
  /** The job that was reached last, and when its picture was there. */
  private last: string | null = null;
  private since = 0;
  private waiting: { job: string | null; go_on: () => void } | null = null;

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
    this.wanted = this.newest = from;
    if (!this.running) void this.run();
  }

  /** Something else is looked at: nothing goes on from where steering was. */
  stop(): void {
    this.wanted = this.newest = this.last = null;
    this.waiting?.go_on();
  }

  /** There is a picture of `job`, or there will be none. */
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
    this.running = true;
    while (this.wanted) {
      const from = this.wanted;
      this.wanted = null;
      await this.step(from);
    }
    this.running = false;
    this.newest = null;
  }

  private async step(from: Placement): Promise<void> {
    const asked = this.steered.watched();
    if (!asked) return;
    const answer = await this.steered.submit(request_like(asked, from));
    if (!answer.ok) return this.refused(answer.failure);
    const job = answer.value;
    const before = this.steered.watched();
    if (before?.id !== asked.id) return this.leave(job); // something else is looked at since
    const leaves = this.leads_past(before);
    const rests = this.own.has(before.id) && !leaves && !is_terminal(before.state);
    this.own.add(job.id);
    this.steps.add(job.id);
    this.last = job.id;
    const shown = this.wait(kMostWaitMs, job.id);
    this.steered.succeed(job, !leaves);
    if (leaves) void this.leave(before);
    if (rests) void this.steered.pause(before.id);
    await shown;
    this.since = Date.now();
  }

  private refused(failure: Failure): Promise<void> {
    this.newest = this.wanted;
    this.steered.fail(failure);
    return this.wait(kRefusedMs);
  }

  /** Whether `job` is a place on the way that nobody misses. */
  private leads_past({ id, state, seconds }: Job): boolean {
    if (this.last === id && Date.now() < this.since + kRestMs) return true;
    return this.steps.has(id) && !is_terminal(state) && seconds < kKeptSeconds;
  }

  private async leave(job: Job): Promise<void> {
    this.left.add(job.id);
    this.steered.forget(job.id);
    this.has_left(job);
    if (is_terminal(job.state)) return;
    const answer = await this.steered.cancel(job.id);
    if (answer.ok) this.has_left(answer.value);
  }

  /** For `most_ms`, or until `job` has arrived. */
  private wait(most_ms: number, job: string | null = null): Promise<void> {
    return new Promise((resolve) => {
      const late = setTimeout(resolve, most_ms);
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

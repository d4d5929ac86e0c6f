import { frame_url, sentence } from './api';
import { draw_chart } from './chart';
import { by_id, make, set_children, set_text } from './dom';
import { format_count, format_percent, format_seconds } from './format';
import { save_with_key, type Notice } from './key_dialog';
import { file_stem, kMethodNames, kStateNames, job_title } from './names';
import { watched_job, type State } from './state';
import { is_terminal, type Job, type JobRequest, type JobState, type Plan } from './wire';

/** What one can do to a job, and in which states. */
export type JobAction = 'cancel' | 'pause' | 'resume' | 'extend' | 'retry';
const kActions: Record<JobAction, readonly JobState[]> = {
  pause: ['queued', 'preparing', 'rendering'],
  resume: ['paused'],
  extend: ['succeeded'],
  retry: ['failed'],
  cancel: ['queued', 'preparing', 'rendering', 'finalizing', 'canceling', 'paused'],
};

/** Twice as far as the job's stop rule and as the job has come, which may be beyond it: where `extend` leads. */
export function further(job: Job): JobRequest['stop'] {
  const { passes, seconds, relative_error } = job.spec.stop;
  const next: JobRequest['stop'] = {};
  if (passes) next.passes = Math.min(1_000_000, 2 * Math.max(passes, job.passes));
  if (seconds) next.seconds = Math.min(1_000_000, 2 * Math.max(seconds, job.seconds));
  if (relative_error) next.relative_error = Math.min(relative_error, job.error || relative_error) / 2;
  return next;
}

/** How far `job` is towards the first of its stop rules, 0 … 1; null where that cannot be said. */
export function progress_of(job: Job): number | null {
  if (job.state === 'succeeded') return 1;
  const { passes, seconds, relative_error } = job.spec.stop;
  const parts: number[] = [];
  if (passes) parts.push(job.passes / passes);
  if (seconds) parts.push(job.seconds / seconds);
  // Noise falls with the square root of the work.
  if (relative_error && job.error) parts.push((relative_error / job.error) ** 2);
  return parts.length > 0 ? Math.min(1, Math.max(...parts)) : null;
}

/** The numbers, the plan and the actions of the watched job. */
export class JobPanel {
  private readonly root = by_id('job', HTMLElement);
  private readonly title = by_id('job-title', HTMLElement);
  private readonly state = by_id('job-state', HTMLElement);
  private readonly actions = (Object.keys(kActions) as JobAction[]).map(
    (action) => ({ action, button: by_id(action, HTMLButtonElement) }));
  private readonly progress = by_id('progress', HTMLProgressElement);
  private readonly announce = by_id('announce', HTMLElement);
  private charted = '';

  constructor(on_action: (job: string, action: JobAction) => void, private readonly on_notice: Notice) {
    for (const { action, button } of this.actions) {
      button.addEventListener('click', () => {
        const id = this.root.dataset['job'];
        if (id) on_action(id, action);
      });
    }
  }

  render(state: State): void {
    const job = watched_job(state);
    this.root.hidden = job === null;
    if (!is_on_the_way(state, job)) set_text(this.announce, job ? `${job_title(state, job)}: ${kStateNames[job.state]}` : '');
    if (!job) return;
    this.root.dataset['job'] = job.id;
    set_text(this.title, job_title(state, job));
    set_text(this.state, kStateNames[job.state]);
    this.state.dataset['state'] = job.state;
    this.render_actions(job.state);
    by_id('job-biased', HTMLElement).hidden = !job.plan?.biased;
    render_progress(this.progress, job);
    render_trouble(job);
    render_numbers(job);
    render_downloads(job, job_title(state, job), this.on_notice);
    render_plan(job.plan);
    this.render_chart(state, job);
  }

  /** Moves the keyboard and the eye to the job. */
  focus(): void {
    this.title.focus();
    by_id('stage', HTMLElement).scrollIntoView({ block: 'nearest' });
  }

  /** Where the focused button goes, the focus goes on to what can be done next, but not to what ends the job. */
  private render_actions(now: JobState): void {
    const focused = this.actions.find(({ button }) => button === document.activeElement)?.button;
    for (const { action, button } of this.actions) {
      button.hidden = !kActions[action].includes(now);
      button.disabled = now === 'canceling';
    }
    if (!focused?.hidden && !focused?.disabled) return;
    const next = this.actions.find(({ action, button }) => !button.hidden && action !== 'cancel');
    (next?.button ?? this.title).focus();
  }

  private render_chart(state: State, job: Job): void {
    by_id('chart-figure', HTMLElement).hidden = state.series.length < 2;
    const key = `${job.id} ${state.series.length} ${state.series.at(-1)?.seconds}`;
    if (key === this.charted) return;
    this.charted = key;
    draw_chart(by_id('chart', SVGSVGElement), state.series, job.spec.stop.relative_error);
  }
}

/** Whether steering leads past `job`, perhaps: several a second are not to be spoken of. */
function is_on_the_way({ steered }: State, job: Job | null): boolean {
  return steered && job !== null && job.revision === 0 && !is_terminal(job.state);
}

function render_progress(bar: HTMLProgressElement, job: Job): void {
  const fraction = progress_of(job);
  bar.hidden = is_terminal(job.state);
  if (fraction === null) bar.removeAttribute('value');
  else bar.value = fraction;
}

function render_trouble(job: Job): void {
  const trouble = trouble_of(job);
  const element = by_id('trouble', HTMLElement);
  element.hidden = trouble === null;
  set_text(element, trouble ?? '');
}

/** Why the job has come to a stop that nobody asked for; null: it has not. */
export function trouble_of(job: Job): string | null {
  if (job.state === 'failed') return sentence(job.failure ?? 'the job failed');
  if (job.state !== 'paused') return null;
  switch (job.paused_because) {
    case 'disk_full': return 'The server\'s disk is full. The job goes on by itself once there is room.';
    case 'disk_unreachable': return 'The server cannot use its data now. The job goes on by itself once it can.';
    default: return null;
  }
}

function render_numbers(job: Job): void {
  const { passes, seconds } = job.spec.stop;
  number('passes', format_count(job.passes), passes && `of ${format_count(passes)}`);
  number('seconds', format_seconds(job.seconds), seconds && `of ${format_seconds(seconds)}`);
  number('error', job.error === null ? '–' : format_percent(job.error), error_notes(job).join(', '));
  number('eta', job.eta_seconds === null ? '–' : format_seconds(job.eta_seconds), null);
  if (job.plan && !job.plan.uses_maps) number('maps', 'not needed', null);
  else number('maps', `${format_count(job.map_hits)} reused`, map_notes(job));
  number('first-frame', job.first_frame_seconds === null ? '–' : format_seconds(job.first_frame_seconds), null);
}

function map_notes(job: Job): string {
  const from_disk = job.map_disk_hits > 0 ? `${format_count(job.map_disk_hits)} from disk, ` : '';
  return `${from_disk}${format_count(job.map_misses)} built`;
}

/** What the error aims at, what it is made of, and what it does not contain. */
export function error_notes(job: Job): string[] {
  const notes: string[] = [];
  if (job.spec.stop.relative_error) notes.push(`to ${format_percent(job.spec.stop.relative_error)}`);
  if (job.noise && job.bias) notes.push(`noise ${format_percent(job.noise)}`, `bias ${format_percent(job.bias)}`);
  if (job.error !== null && job.plan?.biased) notes.push('noise only');
  if (job.rejected_samples > 0) notes.push(`${format_count(job.rejected_samples)} samples rejected`);
  return notes;
}

/** A number with what it is measured against in small. */
function number(id: string, value: string, beside: string | number | null): void {
  const element = by_id(id, HTMLElement);
  set_children(element, `${value} ${beside ?? ''}`, () => (beside ? [new Text(`${value} `), make('small', {}, String(beside))] : [new Text(value)]));
}

function render_downloads(job: Job, title: string, on_notice: Notice): void {
  for (const format of ['png', 'exr'] as const) {
    const link = by_id(`download-${format}`, HTMLAnchorElement);
    link.hidden = job.revision === 0;
    link.setAttribute('href', frame_url(job.id, 'latest', format));
    link.setAttribute('aria-label', `Download ${format.toUpperCase()}`);
    link.onclick = (event) => save_with_key(event, on_notice);
    link.download = [file_stem(title), `${job.id}.${format}`].filter(Boolean).join('-');
  }
}

function render_plan(plan: Plan | null): void {
  by_id('plan', HTMLElement).hidden = !plan;
  if (!plan) return;
  set_text(by_id('plan-method', HTMLElement), kMethodNames[plan.method]);
  set_children(by_id('plan-items', HTMLElement), JSON.stringify(plan.items), () =>
    plan.items.map((item) =>
      make('li', { 'data-active': String(item.active) },
        make('b', {}, item.feature.replaceAll('_', ' ')),
        make('span', { class: 'unseen' }, item.active ? ' (used)' : ' (not used)'),
        `: ${item.reason}`)));
}

import { by_id, make, set_children } from './dom';
import { format_count } from './format';
import { kStateNames, job_title } from './names';
import type { State } from './state';
import type { Job } from './wire';

/** The list of jobs; each links to itself by the address's hash. */
export class JobList {
  private readonly list = by_id('jobs', HTMLElement);
  private readonly none = by_id('no-jobs', HTMLElement);
  private readonly older = by_id('older', HTMLButtonElement);

  constructor(on_older: () => void) {
    this.older.addEventListener('click', on_older);
  }

  render(state: State): void {
    const rows = state.jobs.map((job) => ({ job, title: job_title(state, job), about: about(job) }));
    const key = JSON.stringify([state.watched, rows.map(({ job, title, about: text }) => [job.id, job.state, title, text])]);
    this.none.hidden = rows.length > 0;
    this.list.hidden = rows.length === 0;
    this.older.hidden = state.older === null;
    set_children(this.list, key, () => rows.map(({ job, title, about: text }) => row(job, title, text, state.watched)));
  }
}

function row(job: Job, title: string, text: string, watched: string | null): HTMLLIElement {
  const link = make('a', { href: `#job=${job.id}`, 'aria-current': job.id === watched ? 'true' : null },
    title,
    make('small', {}, make('span', { class: 'state', 'data-state': job.state }, kStateNames[job.state]), ` · ${text}`));
  return make('li', {}, link);
}

/** What the list says of `job` beside its state. */
export function about(job: Job): string {
  const biased = job.plan?.biased ? ' · biased preview' : '';
  return `${format_count(job.passes)} ${job.passes === 1 ? 'pass' : 'passes'} · ${job.spec.film.width} × ${job.spec.film.height}${biased}`;
}

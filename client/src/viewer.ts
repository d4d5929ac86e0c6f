import type { FramePicture } from './api';
import { by_id, set_text } from './dom';
import { same, type FrameKey, type View } from './frames';
import { watched_job, watched_placement, type Absence, type State } from './state';
import { is_terminal, type Job } from './wire';

const kMissing: Record<Absence, string> = {
  deleted: 'This job has been deleted.',
  unknown: 'The server does not know this job (any more).',
};

/** The stage with the picture of the watched job or with its error, and what chooses between them. */
export class Viewer {
  private readonly stage = by_id('stage', HTMLElement);
  private readonly canvas = by_id('picture', HTMLCanvasElement);
  private readonly placeholder = by_id('placeholder', HTMLElement);
  private readonly legend = by_id('legend', HTMLElement);
  private readonly steering = by_id('steering', HTMLElement);
  private readonly choices = (['picture', 'error'] as const).map(
    (view) => ({ view, button: by_id(`show-${view}`, HTMLButtonElement) }));
  private drawn: FrameKey | null = null;
  /** Whether another place can be looked from. */
  private steerable = false;

  constructor(on_view: (view: View) => void) {
    for (const { view, button } of this.choices) button.addEventListener('click', () => on_view(view));
  }

  /** Empties the stage where something else is shown than is looked at, and says what is being waited for. */
  render(state: State): void {
    const job = watched_job(state);
    if (!this.shows(state, job)) this.drawn = null;
    this.canvas.hidden = this.drawn === null;
    this.placeholder.hidden = this.drawn !== null;
    set_text(this.placeholder, state.missing ? kMissing[state.missing] : waiting_for(job, state.view));
    this.legend.hidden = this.drawn?.view !== 'error';
    set_text(this.legend, legend_of(job));
    this.steerable = watched_placement(state) !== null;
    this.steering.hidden = this.drawn === null || !this.steerable;
    this.canvas.toggleAttribute('data-steerable', this.steerable);
    this.canvas.tabIndex = this.steerable ? 0 : -1;
    if (this.steerable) this.canvas.setAttribute('aria-describedby', 'steering');
    else this.canvas.removeAttribute('aria-describedby');
    for (const choice of this.choices) choice.button.setAttribute('aria-pressed', String(choice.view === state.view));
  }

  /** Whether what is drawn may stay: it is what is looked at, or what that takes the place of. */
  private shows({ view, steered }: State, job: Job | null): boolean {
    if (same(this.drawn, job && { job: job.id, view })) return true;
    if (!job || !steered || !this.drawn || this.drawn.job === job.id) return false;
    return job.revision > 0 || !is_terminal(job.state);
  }

  draw(picture: FramePicture, key: FrameKey, description: string): void {
    const { bitmap } = picture;
    this.canvas.width = bitmap.width;
    this.canvas.height = bitmap.height;
    this.canvas.getContext('2d')?.drawImage(bitmap, 0, 0);
    this.stage.style.setProperty('--aspect', String(bitmap.width / bitmap.height));
    this.canvas.dataset['job'] = key.job;
    this.canvas.dataset['view'] = key.view;
    this.canvas.dataset['revision'] = String(key.revision);
    this.canvas.setAttribute('aria-label', description);
    bitmap.close();
    this.drawn = key;
    this.canvas.hidden = false;
    this.placeholder.hidden = true;
    this.legend.hidden = key.view !== 'error';
    this.steering.hidden = !this.steerable;
  }
}

function legend_of(job: Job | null): string {
  const bound = job?.plan?.biased ? 'the 95 % bound of its noise, without the bias of the method' : 'its 95 % bound';
  return `Each pixel shows how wrong the picture may be there: ${bound}, eight times as bright.`;
}

function waiting_for(job: Job | null, view: View): string {
  return view === 'error' && job && job.revision > 0 ? waiting_for_error(job) : waiting_for_picture(job);
}

function waiting_for_error(job: Job): string {
  switch (job.state) {
    case 'succeeded': return 'The error is on its way …';
    case 'failed': case 'canceling': case 'canceled': return 'There is no error of this picture: the job has ended before.';
    case 'paused': return 'The error comes with the next picture, once the job goes on.';
    default: return 'The error comes with the next picture …';
  }
}

function waiting_for_picture(job: Job | null): string {
  switch (job?.state) {
    case undefined: return 'Choose a scene and start: the picture appears here and refines while you watch.';
    case 'queued': return 'Waiting for its turn …';
    case 'preparing': return 'Preparing the scene …';
    case 'paused': return 'Paused before there was a picture.';
    case 'rendering': case 'finalizing': return 'Waiting for the first picture …';
    case 'succeeded': return 'The picture is on its way …';
    case 'canceling': case 'canceled': return 'Canceled before there was a picture.';
    case 'failed': return 'There is no picture of this job.';
  }
}

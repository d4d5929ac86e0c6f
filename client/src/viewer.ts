import type { FramePicture } from './api';
import { by_id, set_text } from './dom';
import type { FrameKey } from './frames';
import type { Job } from './wire';

/** The stage with the picture of the watched job. */
export class Viewer {
  private readonly stage = by_id('stage', HTMLElement);
  private readonly canvas = by_id('picture', HTMLCanvasElement);
  private readonly placeholder = by_id('placeholder', HTMLElement);
  private drawn: FrameKey | null = null;

  /** Empties the stage where `job` is not the one that is shown, and says what is being waited for. */
  render(job: Job | null, missing: boolean): void {
    if (this.drawn && this.drawn.job !== job?.id) this.drawn = null;
    this.canvas.hidden = this.drawn === null;
    this.placeholder.hidden = this.drawn !== null;
    set_text(this.placeholder, missing ? 'The server does not know this job (any more).' : waiting_for(job));
  }

  draw(picture: FramePicture, key: FrameKey, description: string): void {
    const { bitmap } = picture;
    this.canvas.width = bitmap.width;
    this.canvas.height = bitmap.height;
    this.canvas.getContext('2d')?.drawImage(bitmap, 0, 0);
    this.stage.style.setProperty('--aspect', String(bitmap.width / bitmap.height));
    this.canvas.dataset['job'] = key.job;
    this.canvas.dataset['revision'] = String(key.revision);
    this.canvas.setAttribute('aria-label', description);
    bitmap.close();
    this.drawn = key;
    this.canvas.hidden = false;
    this.placeholder.hidden = true;
  }
}

function waiting_for(job: Job | null): string {
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

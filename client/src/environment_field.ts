import { by_id, make, set_children, set_text } from './dom';
import { environment_title, type State } from './state';
import type { EnvironmentChoice } from './wire';

/** What lights the scene from around: nothing but the scene itself, or an uploaded map, turned and scaled. */
export class EnvironmentField {
  private readonly select = by_id('environment', HTMLSelectElement);
  private readonly more = by_id('environment-more', HTMLElement);
  private readonly rotation = by_id('environment-rotation', HTMLInputElement);
  private readonly scale = by_id('environment-scale', HTMLInputElement);

  constructor(on_choice: (id: string | null) => void) {
    this.select.addEventListener('change', () => on_choice(this.select.value || null));
  }

  render({ environments, environment }: State): void {
    set_children(this.select, JSON.stringify(environments), () => [
      make('option', { value: '' }, 'As the scene says'),
      ...environments.map((known) => make('option', { value: known.id }, environment_title(known))),
    ]);
    this.select.value = environment ?? '';
    this.more.hidden = environment === null;
    for (const input of [this.rotation, this.scale]) input.disabled = environment === null;
  }

  /** Null: the scene's own surroundings. */
  read(): EnvironmentChoice | null {
    if (this.select.value === '') return null;
    return { id: this.select.value, rotation_deg: this.rotation.valueAsNumber, scale: this.scale.valueAsNumber };
  }

  /** How an upload goes; `failed` where it did not work. */
  show_upload(text: string, failed: boolean): void {
    const status = by_id('environment-status', HTMLElement);
    status.dataset['failed'] = String(failed);
    set_text(status, text);
  }
}

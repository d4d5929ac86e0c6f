import { by_id, make, set_children } from './dom';
import { placement_of, readable } from './placement';
import type { Placement, SceneReport, Triple } from './wire';

const kElsewhere = 'elsewhere';
const kAxes = ['x', 'y', 'z'] as const;

/** Where the picture is taken from: a camera of the scene, or a place that is typed in. */
export class CameraField {
  private readonly select = by_id('camera', HTMLSelectElement);
  private readonly more = by_id('camera-more', HTMLElement);
  private readonly eye = kAxes.map((axis) => by_id(`camera-eye-${axis}`, HTMLInputElement));
  private readonly target = kAxes.map((axis) => by_id(`camera-target-${axis}`, HTMLInputElement));
  private readonly angle = by_id('camera-angle', HTMLInputElement);
  private report: SceneReport | null = null;
  /** The camera of the scene that was chosen last. */
  private chosen = 0;
  /** What is up there, if it is not +Y. */
  private up: Triple | undefined;

  constructor() {
    this.select.addEventListener('change', () => this.choose());
  }

  render(report: SceneReport | null): void {
    this.report = report;
    const cameras = report?.cameras ?? [];
    set_children(this.select, JSON.stringify([report?.id, cameras]), () => {
      this.chosen = 0;
      const elsewhere = make('option', { value: kElsewhere }, 'Elsewhere …');
      const known = cameras.map(({ name }, index) =>
        make('option', { value: String(index) }, name || `Camera ${index + 1}`));
      return known.length > 0 ? [...known, elsewhere] : [];
    });
    this.select.disabled = cameras.length === 0;
    this.show();
  }

  read(): number | Placement {
    if (!this.is_elsewhere()) return this.chosen;
    const up = this.up ? { up: this.up } : {};
    return { eye: triple_of(this.eye), target: triple_of(this.target), ...up, yfov_deg: this.angle.valueAsNumber };
  }

  /** Chooses this place. */
  place(at: Placement): void {
    this.select.value = kElsewhere;
    this.fill(at);
    this.show();
  }

  private is_elsewhere(): boolean {
    return this.select.value === kElsewhere;
  }

  /** A place elsewhere begins where the camera is that was chosen before. */
  private choose(): void {
    const camera = this.report?.cameras[this.chosen];
    if (!this.is_elsewhere()) this.chosen = this.select.selectedIndex;
    else if (camera) this.fill(placement_of(camera, this.report));
    this.show();
  }

  private fill(at: Placement): void {
    const { eye, target, up, yfov_deg } = readable(at);
    eye.forEach((value, axis) => { this.eye[axis]!.value = String(value); });
    target.forEach((value, axis) => { this.target[axis]!.value = String(value); });
    this.up = up;
    this.angle.value = String(yfov_deg);
  }

  private show(): void {
    this.more.hidden = !this.is_elsewhere();
    for (const input of [...this.eye, ...this.target, this.angle]) input.disabled = this.more.hidden;
  }
}

function triple_of(inputs: HTMLInputElement[]): Triple {
  const [x = 0, y = 0, z = 0] = inputs.map((input) => input.valueAsNumber);
  return [x, y, z];
}

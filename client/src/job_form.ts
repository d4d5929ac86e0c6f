import type { Failure } from './api';
import { describe } from './api';
import { CameraField } from './camera_field';
import { by_id, make, set_children, set_text } from './dom';
import { EnvironmentField } from './environment_field';
import { kMethodHints, kMethodNames } from './names';
import { SceneReportView } from './scene_report';
import { chosen_report, scene_title, type State } from './state';
import type { JobRequest, Method, Placement, Scene } from './wire';

export interface JobFormHandlers {
  on_scene(id: string): void;
  on_environment(id: string | null): void;
  /** Scenes and environment maps. */
  on_files(files: File[]): void;
  on_submit(request: JobRequest): void;
}

/** Fields by the JSON pointer of what they set: the input to mark, and where the message goes. */
const kFields: Record<string, { input: string; error: string }> = {
  '/scene': { input: 'scene', error: 'scene-error' },
  '/environment': { input: 'environment', error: 'environment-error' },
  '/environment/id': { input: 'environment', error: 'environment-error' },
  '/environment/rotation_deg': { input: 'environment-rotation', error: 'environment-error' },
  '/environment/scale': { input: 'environment-scale', error: 'environment-error' },
  '/camera': { input: 'camera', error: 'camera-error' },
  '/camera/eye': { input: 'camera-eye-x', error: 'camera-error' },
  '/camera/target': { input: 'camera-target-x', error: 'camera-error' },
  '/camera/up': { input: 'camera-target-x', error: 'camera-error' },
  '/camera/yfov_deg': { input: 'camera-angle', error: 'camera-error' },
  '/film': { input: 'width', error: 'film-error' },
  '/film/width': { input: 'width', error: 'film-error' },
  '/film/height': { input: 'height', error: 'film-error' },
  '/method': { input: 'method', error: 'method-error' },
  '/stop': { input: 'stop-passes', error: 'stop-error' },
  '/stop/passes': { input: 'stop-passes', error: 'stop-error' },
  '/stop/seconds': { input: 'stop-seconds', error: 'stop-error' },
  '/stop/relative_error': { input: 'stop-relative', error: 'stop-error' },
  '/photons_per_pass': { input: 'photons', error: 'photons-error' },
  '/seed': { input: 'seed', error: 'seed-error' },
};

/** What the form asks for. */
export class JobForm {
  private readonly form = by_id('job-form', HTMLFormElement);
  private readonly scene = by_id('scene', HTMLSelectElement);
  private readonly camera = new CameraField();
  private readonly start = by_id('start', HTMLButtonElement);
  private readonly failure = by_id('form-error', HTMLElement);
  private readonly report = new SceneReportView();
  private readonly environment: EnvironmentField;
  /** What method auto would choose for the chosen scene. */
  private planned: Method | null = null;

  constructor(private readonly handlers: JobFormHandlers) {
    this.environment = new EnvironmentField((id) => handlers.on_environment(id));
    this.scene.addEventListener('change', () => handlers.on_scene(this.scene.value));
    this.form.addEventListener('submit', (event) => this.submit(event));
    this.form.addEventListener('change', () => this.show_hint());
    this.form.addEventListener('input', () => this.clear_errors());
    // The browser points at what is invalid only where it can be seen.
    this.form.addEventListener('invalid', () => { by_id('more', HTMLDetailsElement).open = true; }, true);
    take_files(handlers.on_files);
    this.show_hint();
  }

  render(state: State): void {
    set_children(this.scene, JSON.stringify(state.scenes), () => scene_options(state.scenes));
    if (state.scene !== null) this.scene.value = state.scene;
    const report = chosen_report(state);
    this.report.render(report);
    this.environment.render(state);
    this.camera.render(typeof report === 'string' ? null : report);
    const known = report && typeof report !== 'string' && state.environment === null; // in another one it may differ
    this.planned = known ? report.plan.method : null;
    this.show_hint();
  }

  /** Where the next picture is taken from; of the chosen scene only. */
  look_from(scene: string, place: Placement): void {
    if (scene === this.scene.value) this.camera.place(place);
  }

  /** While a request is on its way the form cannot be sent again. */
  set_busy(busy: boolean): void {
    this.start.disabled = busy;
    set_text(this.start, busy ? 'Starting …' : 'Start');
  }

  /** How the upload of an environment goes. */
  show_environment_upload(text: string, failed = false): void {
    this.environment.show_upload(text, failed);
  }

  /** How that of a scene goes; `failed` where it did not work. */
  show_upload(text: string, failed = false): void {
    const status = by_id('upload-status', HTMLElement);
    status.dataset['failed'] = String(failed);
    set_text(status, text);
  }

  /** Says at the field, or else below the button, why the job was refused. */
  show_failure(failure: Failure): void {
    const pointer = failure.kind === 'problem' ? failure.problem.pointer : '';
    const words = describe(failure);
    const field = kFields[pointer];
    if (field) return this.mark(field, words);
    show(this.failure, words);
    this.start.focus(); // which it lost while a request was on its way
  }

  private submit(event: SubmitEvent): void {
    event.preventDefault();
    this.clear_errors();
    const request = this.read();
    if (!request.scene) return this.mark(kFields['/scene']!, 'Choose a scene first.');
    if (Object.keys(request.stop).length === 0) return this.mark(kFields['/stop']!, 'Give at least one of these.');
    this.handlers.on_submit(request);
  }

  private read(): JobRequest {
    const stop: JobRequest['stop'] = {};
    if (given('stop-passes')) stop.passes = value_of('stop-passes');
    if (given('stop-seconds')) stop.seconds = value_of('stop-seconds');
    if (given('stop-relative')) stop.relative_error = value_of('stop-relative') / 100;
    return {
      scene: this.scene.value,
      environment: this.environment.read(),
      camera: this.camera.read(),
      film: { width: value_of('width'), height: value_of('height') },
      method: this.method(),
      ...(given('photons') && { photons_per_pass: value_of('photons') }),
      seed: String(value_of('seed')),
      stop,
    };
  }

  private method(): Method {
    return String(new FormData(this.form).get('method')) as Method;
  }

  private show_hint(): void {
    const method = this.method();
    const here = method === 'auto' && this.planned ? ` Here: ${kMethodNames[this.planned]}.` : '';
    set_text(by_id('method-hint', HTMLElement), kMethodHints[method] + here);
  }

  private mark(field: { input: string; error: string }, words: string): void {
    const input = by_id(field.input, HTMLElement);
    input.setAttribute('aria-invalid', 'true');
    show(by_id(field.error, HTMLElement), words);
    if (by_id('more', HTMLElement).contains(input)) by_id('more', HTMLDetailsElement).open = true;
    input.focus();
  }

  private clear_errors(): void {
    for (const { input, error } of Object.values(kFields)) {
      by_id(input, HTMLElement).removeAttribute('aria-invalid');
      by_id(error, HTMLElement).hidden = true;
    }
    this.failure.hidden = true;
  }
}

function scene_options(scenes: Scene[]): Node[] {
  const group = (label: string, members: Scene[]) =>
    members.length === 0 ? [] : [make('optgroup', { label }, ...members.map(scene_option))];
  return [
    ...group('Samples', scenes.filter((scene) => scene.sample)),
    ...group('Uploaded', scenes.filter((scene) => !scene.sample)),
  ];
}

function scene_option(scene: Scene): HTMLOptionElement {
  return make('option', { value: scene.id }, scene_title(scene));
}

/** Files come by the file fields or by dropping them anywhere on the page. */
function take_files(on_files: (files: File[]) => void): void {
  for (const input of [by_id('file', HTMLInputElement), by_id('environment-file', HTMLInputElement)]) {
    input.addEventListener('change', () => {
      const files = [...input.files ?? []];
      input.value = ''; // so that the same file may be chosen again
      on_files(files);
    });
  }
  const targets = ['stage', 'drop', 'environment-drop'].map((id) => by_id(id, HTMLElement));
  const mark = (dropping: boolean) => targets.forEach((target) => target.toggleAttribute('data-dropping', dropping));
  const has_files = (event: DragEvent) => event.dataTransfer?.types.includes('Files') ?? false;
  addEventListener('dragover', (event) => {
    if (!has_files(event)) return;
    event.preventDefault();
    mark(true);
  });
  addEventListener('dragleave', (event) => { if (event.relatedTarget === null) mark(false); });
  addEventListener('drop', (event) => {
    if (!has_files(event)) return;
    event.preventDefault();
    mark(false);
    on_files([...event.dataTransfer?.files ?? []]);
  });
}

function given(id: string): boolean {
  return by_id(id, HTMLInputElement).value !== '';
}

function value_of(id: string): number {
  return by_id(id, HTMLInputElement).valueAsNumber;
}

function show(element: HTMLElement, words: string): void {
  set_text(element, words);
  element.hidden = false;
}

import { by_id, make, set_children, set_text } from './dom';
import { format_count, format_length } from './format';
import type { SceneReport } from './wire';

/** What is in the chosen scene, and what of it is not shown as its author meant. */
export class SceneReportView {
  private readonly root = by_id('report', HTMLElement);
  private readonly warnings = by_id('report-warnings', HTMLElement);

  /** `report`: a sentence where there is none; null while it is on its way. */
  render(report: SceneReport | string | null): void {
    this.root.hidden = report === null;
    if (report === null) return;
    const warnings = typeof report === 'string' ? [] : report.warnings;
    set_text(by_id('report-counts', HTMLElement), typeof report === 'string' ? report : summary(report));
    this.warnings.hidden = warnings.length === 0;
    set_text(by_id('report-warnings-count', HTMLElement), plural(warnings.length, 'warning'));
    set_children(by_id('report-warnings-list', HTMLElement), JSON.stringify(warnings), () =>
      warnings.map((warning) => make('li', {}, warning)));
  }
}

/** `1 204 triangles, 3 materials, 1 light, 2.0 × 2.0 × 2.0 m`. */
export function summary(report: SceneReport): string {
  const parts = [
    plural(report.triangles, 'triangle'), plural(report.materials, 'material'), plural(report.lights, 'light'),
  ];
  if (report.size) parts.push(report.size.map(format_length).join(' × '));
  return parts.join(', ');
}

function plural(count: number, noun: string): string {
  return `${format_count(count)} ${noun}${count === 1 ? '' : 's'}`;
}

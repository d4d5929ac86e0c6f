import { by_id, make, set_children, set_text } from './dom';
import { format_count, format_lengths } from './format';
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

/** `1 204 triangles, 3 materials; lit by 2 emissive triangles; 2 × 2.5 × 2 m`. */
export function summary(report: SceneReport): string {
  const lit_by: string[] = [];
  if (report.lights > 0) lit_by.push(plural(report.lights, 'light'));
  if (report.emissive_triangles > 0) lit_by.push(plural(report.emissive_triangles, 'emissive triangle'));
  if (report.environment) lit_by.push('its surroundings');
  return [
    `${plural(report.triangles, 'triangle')}, ${plural(report.materials, 'material')}`,
    ...(lit_by.length > 0 ? [`lit by ${lit_by.join(' and ')}`] : []),
    ...(report.size ? [format_lengths(report.size)] : []),
  ].join('; ');
}

function plural(count: number, noun: string): string {
  return `${format_count(count)} ${noun}${count === 1 ? '' : 's'}`;
}

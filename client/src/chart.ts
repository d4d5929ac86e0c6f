import { format_percent, format_seconds } from './format';
import type { SeriesPoint } from './wire';

const kWidth = 420;
const kHeight = 200;
const kLeft = 52;
const kRight = 12;
const kTop = 10;
const kBottom = 26;

/** A logarithmic axis: `place` maps a value to a coordinate, `ticks` are round values within. */
export interface LogAxis {
  place(value: number): number;
  ticks: number[];
}

/** An axis from coordinate `start` to `end` that holds all `values` (positive), widened to a factor of three, so that a tick falls in. */
export function log_axis(values: number[], start: number, end: number): LogAxis {
  let low = Math.min(...values);
  let high = Math.max(...values);
  if (high < 3 * low) {
    const middle = Math.sqrt(low * high);
    low = middle / Math.sqrt(3);
    high = middle * Math.sqrt(3);
  }
  const place = (value: number) => start + ((end - start) * Math.log(value / low)) / Math.log(high / low);
  return { place, ticks: log_ticks(low, high) };
}

/** Round values within [low, high]: powers of ten where there are three of them, else finer steps. */
export function log_ticks(low: number, high: number): number[] {
  const powers: number[] = [];
  for (let power = Math.floor(Math.log10(low)); power <= Math.ceil(Math.log10(high)); ++power) powers.push(power);
  const within = (steps: number[]) =>
    powers.flatMap((power) => steps.map((step) => Number(`${step}e${power}`))).filter((tick) => tick >= low && tick <= high);
  const choices = [within([1]), within([1, 2, 5]), within([1, 2, 3, 4, 5, 6, 8])];
  return choices.find((ticks) => ticks.length >= 3) ?? choices[2]!;
}

/** Draws error over seconds, both logarithmic (noise falls on a straight line), with `target` as a dashed line. */
export function draw_chart(svg: SVGSVGElement, points: SeriesPoint[], target: number | null): void {
  const shown = points.filter((point) => point.seconds > 0 && point.error > 0);
  const last = shown[shown.length - 1];
  if (!last) return svg.replaceChildren();
  const x = log_axis(shown.map((point) => point.seconds), kLeft, kWidth - kRight);
  const errors = shown.map((point) => point.error);
  const y = log_axis(target ? [...errors, target] : errors, kHeight - kBottom, kTop);
  const at = (point: SeriesPoint) => [x.place(point.seconds), y.place(point.error)] as const;
  svg.replaceChildren(
    ...x.ticks.flatMap((tick) => vertical(x.place(tick), tick_label(tick))),
    ...y.ticks.flatMap((tick) => horizontal(y.place(tick), format_percent(tick))),
    ...(target ? [line('target', kLeft, y.place(target), kWidth - kRight, y.place(target))] : []),
    shape('polyline', { class: 'curve', points: shown.map((point) => at(point).map(rounded).join(',')).join(' ') }),
    shape('circle', { class: 'point', cx: rounded(at(last)[0]), cy: rounded(at(last)[1]), r: '3.5' }),
  );
  svg.setAttribute('aria-label', `Error over compute time: ${format_percent(last.error)} after ${format_seconds(last.seconds)}`);
}

function vertical(x: number, label: string): SVGElement[] {
  return [line('grid', x, kTop, x, kHeight - kBottom), words(label, x, kHeight - 8, 'middle')];
}

function horizontal(y: number, label: string): SVGElement[] {
  return [line('grid', kLeft, y, kWidth - kRight, y), words(label, kLeft - 6, y + 4, 'end')];
}

function line(kind: string, x1: number, y1: number, x2: number, y2: number): SVGElement {
  return shape('line', { class: kind, x1: rounded(x1), y1: rounded(y1), x2: rounded(x2), y2: rounded(y2) });
}

function words(label: string, x: number, y: number, anchor: string): SVGElement {
  const element = shape('text', { x: rounded(x), y: rounded(y), 'text-anchor': anchor });
  element.textContent = label;
  return element;
}

function shape(tag: string, attributes: Record<string, string>): SVGElement {
  const element = document.createElementNS('http://www.w3.org/2000/svg', tag);
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
  return element;
}

function tick_label(seconds: number): string {
  return seconds < 10 ? `${seconds} s` : format_seconds(seconds);
}

function rounded(value: number): string {
  return value.toFixed(1);
}

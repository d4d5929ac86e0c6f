// What was measured, beside what was to be reached.

export function quantile(values, q) {
  const sorted = [...values].sort((a, b) => a - b);
  if (sorted.length === 0) return NaN;
  return sorted[Math.min(sorted.length - 1, Math.ceil(q * sorted.length) - 1)];
}

export const median = (values) => quantile(values, 0.5);
export const sleep = (ms) => new Promise((resolve) => setTimeout(resolve, ms));

export class Figures {
  rows = [];

  /** A figure that must lie below (or, by `least`, not below) its target. NaN misses every target. */
  below(what, measured, target, unit = '') {
    this.#add(what, `< ${target}${unit}`, `${round(measured)}${unit}`, measured < target);
  }
  exactly(what, measured, target) {
    this.#add(what, `${target}`, `${measured}`, measured === target);
  }
  /** What has no target. */
  note(what, measured) {
    this.#add(what, '', `${measured}`, true);
  }

  #add(what, target, measured, held) {
    this.rows.push({ what, target, measured, held });
    process.stderr.write(`load: ${what}: ${measured}${target && ` (${target})`}${held ? '' : ' MISSED'}\n`);
  }

  get missed() {
    return this.rows.filter((row) => !row.held);
  }

  markdown() {
    const lines = this.rows.map((row) => `| ${row.what} | ${row.target} | ${row.measured} | ${row.target ? (row.held ? 'held' : '**missed**') : ''} |`);
    return ['| figure | target | measured | |', '|---|---|---|---|', ...lines].join('\n');
  }
}

const round = (value) => (Math.abs(value) >= 100 ? value.toFixed(0) : value.toPrecision(3));

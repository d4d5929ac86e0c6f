const kJoint = '\u00a0'; // between a number and its unit: no line ends there

/** `1.2 s`, `12 s`, `3 min 05 s`, `2 min`, `2 h 04 min`. */
export function format_seconds(seconds: number): string {
  if (seconds < 9.95) return `${seconds.toFixed(1)}${kJoint}s`;
  const whole = Math.round(seconds);
  if (whole < 100) return `${whole}${kJoint}s`;
  if (whole < 3600) return two_units(Math.floor(whole / 60), 'min', whole % 60, 's');
  const minutes = Math.round(seconds / 60);
  return two_units(Math.floor(minutes / 60), 'h', minutes % 60, 'min');
}

/** A fraction as per cent with two significant digits or more: `0.034 %`, `4.1 %`, `123 %`. */
export function format_percent(fraction: number): string {
  const percent = fraction * 100;
  if (percent === 0) return `0${kJoint}%`;
  const digits = Math.min(4, Math.max(0, 1 - Math.floor(Math.log10(Math.abs(percent)))));
  return `${percent.toFixed(digits)}${kJoint}%`;
}

/** A whole number with thin spaces between thousands. */
export function format_count(value: number): string {
  return Math.round(value).toString().replace(/\B(?=(\d{3})+$)/g, '\u2009');
}

/** Lengths in metres, in the unit that suits the longest: `2 × 2.5 × 2 m`, `3.2 × 1 × 0 cm`. */
export function format_lengths(metres: number[]): string {
  const longest = Math.max(...metres);
  const [scale, unit] = longest >= 1 || longest === 0 ? [1, 'm'] : longest >= 0.01 ? [100, 'cm'] : [1000, 'mm'];
  const lengths = metres.map((length) => Number((length * scale).toPrecision(3)));
  return `${lengths.join(`${kJoint}×${kJoint}`)}${kJoint}${unit}`;
}

function two_units(large: number, large_unit: string, small: number, small_unit: string): string {
  const rest = small === 0 ? '' : ` ${small.toString().padStart(2, '0')}${kJoint}${small_unit}`;
  return `${large}${kJoint}${large_unit}${rest}`;
}

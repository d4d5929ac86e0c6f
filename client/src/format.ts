/** `7 s`, `12.4 s`, `3 min 05 s`, `2 h 04 min`. */
export function format_seconds(seconds: number): string {
  if (seconds < 9.95) return `${seconds.toFixed(1)} s`;
  const whole = Math.round(seconds);
  if (whole < 60) return `${whole} s`;
  if (whole < 3600) return `${Math.floor(whole / 60)} min ${two_digits(whole % 60)} s`;
  const minutes = Math.round(seconds / 60);
  return `${Math.floor(minutes / 60)} h ${two_digits(minutes % 60)} min`;
}

/** A fraction as per cent with two significant digits or more: `0.034 %`, `4.1 %`, `123 %`. */
export function format_percent(fraction: number): string {
  const percent = fraction * 100;
  if (percent === 0) return '0 %';
  const digits = Math.min(4, Math.max(0, 1 - Math.floor(Math.log10(Math.abs(percent)))));
  return `${percent.toFixed(digits)} %`;
}

/** A whole number with thin spaces between thousands. */
export function format_count(value: number): string {
  return Math.round(value).toString().replace(/\B(?=(\d{3})+$)/g, '\u2009');
}

/** `812 B`, `1.4 kB`, `3.2 MB`. */
export function format_bytes(bytes: number): string {
  if (bytes < 1000) return `${bytes} B`;
  const units = ['kB', 'MB', 'GB', 'TB'];
  let value = bytes / 1000;
  let unit = 0;
  for (; value >= 999.5 && unit < units.length - 1; ++unit) value /= 1000;
  return `${value.toFixed(value < 9.95 ? 1 : 0)} ${units[unit]}`;
}

/** A length in metres: `3.2 mm`, `1.25 m`. */
export function format_length(metres: number): string {
  const size = Math.abs(metres);
  if (size > 0 && size < 0.01) return `${(metres * 1000).toPrecision(2)} mm`;
  if (size < 1) return `${(metres * 100).toPrecision(2)} cm`;
  return `${metres.toPrecision(3)} m`;
}

function two_digits(value: number): string {
  return value.toString().padStart(2, '0');
}

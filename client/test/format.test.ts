import { describe, expect, it } from 'vitest';
import { log_axis, log_ticks } from '../src/chart';
import { format_count, format_lengths, format_percent, format_seconds } from '../src/format';
import { about } from '../src/job_list';
import { error_notes, further, progress_of, trouble_of } from '../src/job_panel';
import { a_job, a_spec } from './messages';

/** With spaces where a line may not break. */
const broken = (text: string) => text.replaceAll('\u00a0', ' ');

describe('numbers for people', () => {
  it.each([
    [0, '0.0 s'], [1.25, '1.3 s'], [9.96, '10 s'], [60, '60 s'], [185, '3 min 05 s'], [599.6, '10 min'], [3599.7, '1 h'], [7440, '2 h 04 min'],
  ])('%d seconds', (seconds, text) => expect(broken(format_seconds(seconds))).toBe(text));

  it.each([
    [0, '0 %'], [0.5, '50 %'], [1.234, '123 %'], [0.0412, '4.1 %'], [0.00034, '0.034 %'], [1e-9, '0.0000 %'],
  ])('%d as per cent', (fraction, text) => expect(broken(format_percent(fraction))).toBe(text));

  it.each([[0, '0'], [999, '999'], [1234567, '1\u2009234\u2009567']])('%d counted', (value, text) => expect(format_count(value)).toBe(text));

  it.each([
    [[2, 2.5, 2], '2 × 2.5 × 2 m'], [[0.25, 0.1, 0], '25 × 10 × 0 cm'], [[0.0021, 0, 0], '2.1 × 0 × 0 mm'], [[0, 0, 0], '0 × 0 × 0 m'],
  ])('%j metres', (metres, text) => expect(broken(format_lengths(metres))).toBe(text));

  it('keeps numbers and their units on one line', () => {
    expect(format_seconds(185)).toBe('3\u00a0min 05\u00a0s');
    expect(format_percent(0.5)).toBe('50\u00a0%');
    expect(format_lengths([1, 2, 3])).toBe('1\u00a0×\u00a02\u00a0×\u00a03\u00a0m');
  });
});

describe('progress_of', () => {
  const rule = { passes: null, seconds: null, relative_error: null };

  it('is that of the rule that is nearest', () => {
    expect(progress_of(a_job({ passes: 4, seconds: 6, spec: a_spec({ stop: { ...rule, passes: 16, seconds: 10 } }) }))).toBe(0.6);
    expect(progress_of(a_job({ error: 0.2, spec: a_spec({ stop: { ...rule, relative_error: 0.1 } }) }))).toBeCloseTo(0.25);
    expect(progress_of(a_job({ passes: 20, spec: a_spec({ stop: { ...rule, passes: 16 } }) }))).toBe(1);
  });

  it('is unknown before there is an error to compare, and whole at the end', () => {
    expect(progress_of(a_job({ error: null, spec: a_spec({ stop: { ...rule, relative_error: 0.1 } }) }))).toBeNull();
    expect(progress_of(a_job({ state: 'succeeded', passes: 1 }))).toBe(1);
  });
});

describe('further', () => {
  it('is twice as far as the rule, or as the job where a pass led beyond it', () => {
    const rule = { passes: 16, seconds: 10, relative_error: 0.1 };
    expect(further(a_job({ spec: a_spec({ stop: rule }), passes: 16, seconds: 4, error: 0.2 }))).toEqual({ passes: 32, seconds: 20, relative_error: 0.05 });
    expect(further(a_job({ spec: a_spec({ stop: rule }), passes: 8, seconds: 25, error: 0.04 }))).toEqual({ passes: 32, seconds: 50, relative_error: 0.02 });
    expect(further(a_job({ spec: a_spec({ stop: { ...rule, passes: null, seconds: null } }), error: null }))).toEqual({ relative_error: 0.05 });
  });
});

describe('error_notes', () => {
  const rule = { passes: null, seconds: null, relative_error: null };
  const plan = { method: 'photon_map' as const, biased: true, uses_maps: true, items: [] };

  it('says what the error is made of where there is more than noise', () => {
    expect(error_notes(a_job()).map(broken)).toEqual(['noise 24 %', 'bias 7.0 %']);
    expect(error_notes(a_job({ bias: 0, spec: a_spec({ stop: { ...rule, relative_error: 0.1 } }) })).map(broken)).toEqual(['to 10 %']);
    expect(error_notes(a_job({ error: null, noise: null, bias: null }))).toEqual([]);
  });

  it('says what it does not contain', () => {
    expect(error_notes(a_job({ bias: 0, plan }))).toEqual(['noise only']);
    expect(error_notes(a_job({ bias: 0, rejected_samples: 3 }))).toEqual(['3 samples rejected']);
  });
});

describe('the list of jobs', () => {
  it('tells how far a job is, and that its method is biased', () => {
    const plan = { method: 'photon_map' as const, biased: true, uses_maps: true, items: [] };
    const spec = a_spec({ film: { width: 64, height: 48 } });
    expect(about(a_job({ passes: 1, spec }))).toBe('1 pass · 64 × 48');
    expect(about(a_job({ passes: 2, spec, plan }))).toBe('2 passes · 64 × 48 · biased preview');
    expect(about(a_job({ passes: 0, spec, plan: null }))).toBe('0 passes · 64 × 48');
  });
});

describe('the axes of the chart', () => {
  it('has powers of ten, or finer steps within one', () => {
    expect(log_ticks(0.5, 200)).toEqual([1, 10, 100]);
    expect(log_ticks(0.9, 12)).toEqual([1, 2, 5, 10]);
    expect(log_ticks(0.15, 0.45)).toEqual([0.2, 0.3, 0.4]);
  });

  it('maps the ends to the ends', () => {
    const axis = log_axis([1, 100], 50, 400);
    expect([1, 10, 100].map(axis.place)).toEqual([50, 225, 400]);
  });

  it('is wide enough for a single value', () => {
    const axis = log_axis([3, 3], 0, 100);
    expect(axis.place(3)).toBeCloseTo(50);
    expect(axis.ticks.length).toBeGreaterThan(0);
  });
});

describe('what is wrong with a job', () => {
  it('is why it failed, or that it waits for room, which nobody asked for', () => {
    expect(trouble_of(a_job())).toBeNull();
    expect(trouble_of(a_job({ state: 'failed', failure: 'there is no camera' }))).toBe('There is no camera.');
    expect(trouble_of(a_job({ state: 'failed' }))).toBe('The job failed.');
    expect(trouble_of(a_job({ state: 'paused', paused_because: 'request' }))).toBeNull();
    expect(trouble_of(a_job({ state: 'paused', paused_because: 'disk_full' }))).toMatch(/disk is full/);
    expect(trouble_of(a_job({ state: 'paused', paused_because: 'disk_unreachable' }))).toMatch(/cannot use its data/);
    expect(trouble_of(a_job({ state: 'canceled', paused_because: 'disk_full' }))).toBeNull();
  });
});

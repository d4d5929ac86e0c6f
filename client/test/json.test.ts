import { describe, expect, it } from 'vitest';
import { read_json, write_json } from '../src/json';

describe('JSON', () => {
  it.each(['0', '7', '9007199254740993', '18446744073709551615'])('keeps the seed %s to the last digit', (seed) => {
    const text = `{"spec":{"radius":0.5,"seed":${seed},"label":""}}`;
    expect(read_json(text)).toEqual({ spec: { radius: 0.5, seed, label: '' } });
    expect(write_json(read_json(text))).toBe(text);
  });

  it('leaves what people wrote as it is', () => {
    const message = { label: '"seed":12, "seed":"12"', name: 'seed' };
    expect(read_json(JSON.stringify(message))).toEqual(message);
    expect(JSON.parse(write_json(message))).toEqual(message);
  });
});

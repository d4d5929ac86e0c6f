import { readFileSync } from 'node:fs';
import { expect, it } from 'vitest';
import { by_tag, kind_words, resolved, scope_of, type Contract, type Schema } from '../src/contract';

const contract = JSON.parse(readFileSync(new URL('../../server/api/openapi.json', import.meta.url), 'utf8')) as Contract;

const words = (schema: Schema) => kind_words(schema).map(({ text }) => text).join('');

it('says in words what values a schema has', () => {
  expect(words({ type: 'integer', minimum: 1, maximum: 16384 })).toBe('whole number, 1 to 16384');
  expect(words({ type: 'integer', minimum: 0 })).toBe('whole number, from 0 on');
  expect(words({ type: 'number', exclusiveMinimum: 0, maximum: 5 })).toBe('number, above 0 to 5');
  expect(words({ type: ['number', 'null'] })).toBe('number or null');
  expect(words({ type: 'string', maxLength: 200 })).toBe('text of at most 200 characters');
  expect(words({ enum: ['png', 'jpg'] })).toBe('png, jpg');
  expect(words({ type: 'array', items: { type: 'number' }, minItems: 3, maxItems: 3 })).toBe('list of 3, each of number');
  expect(words({ oneOf: [{ type: 'integer' }, { const: 'latest' }] })).toBe('whole number or latest');
  expect(kind_words({ $ref: '#/components/schemas/Job' })).toEqual([{ text: 'Job', name: 'Job' }]);
});

it('finds every operation under one tag, and what key it needs', () => {
  const all = [...by_tag(contract).values()].flat();
  expect(all.length).toBe(Object.values(contract.paths).flatMap(Object.keys).length);
  const scope = (id: string) => scope_of(contract, all.find(({ operation }) => operation.operationId === id)!.operation);
  expect(scope('health')).toBe(null);
  expect(scope('listJobs')).toBe('read');
  expect(scope('submitJob')).toBe('submit');
});

it('follows references', () => {
  const ref = { $ref: '#/components/schemas/JobState' } as Schema;
  expect(resolved(contract, ref).enum).toContain('queued');
});

/** The parts of an OpenAPI 3.1 document that the page shows. It is the service's own, so its shape is taken as given. */
export interface Contract {
  info: { title: string; version: string; description: string };
  security: Security[];
  paths: Record<string, Record<string, Operation>>;
  components: {
    schemas: Record<string, Schema>;
    securitySchemes: Record<string, { description: string }>;
  };
}

type Security = Record<string, string[]>;

export interface Operation {
  operationId: string;
  summary: string;
  description?: string;
  tags: string[];
  security?: Security[];
  parameters?: Parameter[];
  requestBody?: { description?: string; content: Record<string, Media> };
  responses: Record<string, Answer>;
}

export interface Parameter { name: string; in: string; description: string; required?: boolean; schema: Schema }
export interface Media { schema: Schema; examples?: Record<string, { summary: string; value: unknown }> }
export interface Answer { description: string; headers?: Record<string, Header>; content?: Record<string, Media> }
export interface Header { description: string; schema: Schema }

export interface Schema {
  $ref?: string;
  type?: string | string[];
  enum?: unknown[];
  const?: unknown;
  format?: string;
  minimum?: number;
  maximum?: number;
  exclusiveMinimum?: number;
  maxLength?: number;
  minItems?: number;
  maxItems?: number;
  items?: Schema;
  properties?: Record<string, Schema>;
  required?: string[];
  oneOf?: Schema[];
  default?: unknown;
  description?: string;
  examples?: unknown[];
}

export interface NamedOperation { method: string; path: string; operation: Operation }

/** All operations by their tag, both in the document's order. */
export function by_tag(contract: Contract): Map<string, NamedOperation[]> {
  const groups = new Map<string, NamedOperation[]>();
  for (const [path, methods] of Object.entries(contract.paths)) {
    for (const [method, operation] of Object.entries(methods)) {
      const tag = operation.tags[0] ?? 'Other';
      groups.set(tag, [...(groups.get(tag) ?? []), { method: method.toUpperCase(), path, operation }]);
    }
  }
  return groups;
}

/** The scope that a key needs for it; null where none is needed. */
export function scope_of(contract: Contract, operation: Operation): string | null {
  const [first] = operation.security ?? contract.security;
  return first?.['key']?.[0] ?? null;
}

/** What `{$ref}` leads to, and else the object itself. */
export function resolved<T extends object>(contract: Contract, object: T): T {
  const ref = (object as { $ref?: string }).$ref;
  if (ref === undefined) return object;
  let found: unknown = contract;
  for (const step of ref.slice(2).split('/')) found = (found as Record<string, unknown>)[step];
  return found as T;
}

/** The name of the schema that is referred to: "Job". */
export function ref_name(schema: Schema): string | null {
  return schema.$ref?.split('/').pop() ?? null;
}

/** What values the schema has, in words: "whole number, 1 to 16384". Names of other schemas are given to `name`. */
export function kind_words(schema: Schema): { text: string; name: string | null }[] {
  const name = ref_name(schema);
  if (name !== null) return [{ text: name, name }];
  if (schema.oneOf) {
    return schema.oneOf.flatMap((branch, index) => [...(index ? [{ text: ' or ', name: null }] : []), ...kind_words(branch)]);
  }
  if (schema.enum) return plain(schema.enum.map(String).join(', '));
  if (schema.const !== undefined) return plain(String(schema.const));
  if (schema.type === 'array' && schema.items) return [...plain(`${array_word(schema)} of `), ...kind_words(schema.items)];
  const types = [schema.type ?? 'bytes'].flat().map((type) => kTypeWords[type] ?? type).join(' or ');
  return plain(types + range_words(schema));
}

const kTypeWords: Record<string, string> = {
  integer: 'whole number', boolean: 'true or false', string: 'text', object: 'object', number: 'number', null: 'null',
};

function plain(text: string): { text: string; name: null }[] {
  return [{ text, name: null }];
}

function array_word({ minItems, maxItems }: Schema): string {
  if (maxItems === undefined) return 'list';
  return minItems === maxItems ? `list of ${maxItems}, each` : `list of at most ${maxItems}, each`;
}

function range_words(schema: Schema): string {
  const { minimum, maximum, exclusiveMinimum, maxLength, format } = schema;
  if (format === 'date-time') return ', date and time';
  if (maxLength !== undefined) return ` of at most ${maxLength} characters`;
  const words: string[] = [];
  if (exclusiveMinimum !== undefined) words.push(`above ${exclusiveMinimum}`);
  if (minimum !== undefined) words.push(maximum === undefined ? `from ${minimum} on` : `${minimum}`);
  if (maximum !== undefined) words.push(`${words.length ? 'to' : 'up to'} ${large(maximum)}`);
  return words.length ? `, ${words.join(' ')}` : '';
}

function large(value: number): string {
  if (value === 2 ** 64) return '2⁶⁴ − 1'; // JSON numbers are doubles here
  return value < 1e15 ? String(value) : value.toExponential().replace('+', '');
}

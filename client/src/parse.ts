/** What a message lacks or has wrong, with the place in it as a JSON pointer. */
export class WireError extends Error {
  constructor(readonly pointer: string, expected: string) {
    super(`expected ${expected} at ${pointer || 'the top'}`);
    this.name = 'WireError';
  }
}

/** Turns a parsed JSON value into a T or throws a WireError that names `pointer`. */
export type Parser<T> = (value: unknown, pointer: string) => T;

export const text: Parser<string> = (value, pointer) => {
  if (typeof value !== 'string') throw new WireError(pointer, 'a string');
  return value;
};

/** A finite number. */
export const number: Parser<number> = (value, pointer) => {
  if (typeof value !== 'number' || !Number.isFinite(value)) throw new WireError(pointer, 'a number');
  return value;
};

/** A whole number from 0 on. */
export const count: Parser<number> = (value, pointer) => {
  const found = number(value, pointer);
  if (!Number.isInteger(found) || found < 0) throw new WireError(pointer, 'a whole number from 0 on');
  return found;
};

/** A whole number from 0 on, as a text of digits. */
export const digits: Parser<string> = (value, pointer) => {
  if (typeof value !== 'string' || !/^\d+$/.test(value)) throw new WireError(pointer, 'a whole number from 0 on');
  return value;
};

export const flag: Parser<boolean> = (value, pointer) => {
  if (typeof value !== 'boolean') throw new WireError(pointer, 'true or false');
  return value;
};

export function one_of<const T extends string>(...allowed: T[]): Parser<T> {
  return (value, pointer) => {
    const found = allowed.find((candidate) => candidate === value);
    if (found === undefined) throw new WireError(pointer, `one of ${allowed.join(', ')}`);
    return found;
  };
}

/** A member that may be absent or null. */
export function maybe<T>(parser: Parser<T>): Parser<T | null> {
  return (value, pointer) => (value === undefined || value === null ? null : parser(value, pointer));
}

export function list<T>(parser: Parser<T>): Parser<T[]> {
  return (value, pointer) => {
    if (!Array.isArray(value)) throw new WireError(pointer, 'a list');
    return value.map((item, index) => parser(item, `${pointer}/${index}`));
  };
}

/** An object with the members of `shape`; further members are ignored. */
export function object<T>(shape: { [K in keyof T]: Parser<T[K]> }): Parser<T> {
  return (value, pointer) => {
    if (typeof value !== 'object' || value === null || Array.isArray(value)) throw new WireError(pointer, 'an object');
    const members = value as Record<string, unknown>;
    const parsed = {} as T;
    for (const name in shape) parsed[name] = shape[name](members[name], `${pointer}/${name}`);
    return parsed;
  };
}

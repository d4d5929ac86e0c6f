let secret = '';
let key_needed = () => {};

/** The key that requests carry from now on; empty: none. `on_needed` is called when the server asks for another. */
export function use_key(key: string, on_needed: () => void): void {
  secret = key;
  key_needed = on_needed;
}

export function has_key(): boolean {
  return secret !== '';
}

/** As fetch, with the key. */
export async function fetch_with_key(url: string, init: RequestInit = {}): Promise<Response> {
  const headers = new Headers(init.headers);
  if (secret) headers.set('Authorization', `Bearer ${secret}`);
  const response = await fetch(url, { ...init, headers });
  if (response.status === 401) key_needed();
  return response;
}

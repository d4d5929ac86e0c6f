/** The part of Khronos' validator that is used here; the package has no types of its own. */
declare module 'gltf-validator' {
  interface Report {
    issues: { numErrors: number; numWarnings: number; messages: unknown[] };
  }
  export function validateBytes(bytes: Uint8Array, options: { uri: string }): Promise<Report>;
}

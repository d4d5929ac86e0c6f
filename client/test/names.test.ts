import { describe, expect, it } from 'vitest';
import { file_stem, label_of } from '../src/names';

describe('label_of', () => {
  it('takes as many characters as a label may have, not halves of them', () => {
    expect(label_of('room.glb')).toBe('room.glb');
    expect(label_of('🎨'.repeat(201))).toBe('🎨'.repeat(200));
  });
});

describe('file_stem', () => {
  it('joins the words of any script, without the ending', () => {
    expect(file_stem('My Scene (final).glb')).toBe('My_Scene_final');
    expect(file_stem('Küche 台所.v2.gltf')).toBe('Küche_台所_v2');
    expect(file_stem('../<b>|:?*\\')).toBe('b');
    expect(file_stem('🎨')).toBe('');
    expect(file_stem('k'.repeat(99))).toBe('k'.repeat(60));
  });
});

// @ts-check
/** What the classes of signs are called, and what else people call them: for the search, in lower case. Pure. */

import { NO_CLASS } from './documents.js';

/**
 * @param {readonly import('../types.js').Label[]} labels
 * @param {number|null|undefined} id   `NO_CLASS`: a person says so; null: nobody has said, and the engine has read none
 */
export function className(labels, id) {
  if (id === NO_CLASS) return 'none of the classes';
  return labels.find((label) => label.id === id)?.name ?? (id === null || id === undefined ? 'no class' : `class ${id}`);
}

/** @type {Readonly<Record<number, string>>} */
export const OTHER_WORDS = Object.freeze({
  6: 'derestricted', 9: 'no passing', 10: 'no passing trucks hgv', 11: 'right of way crossroads intersection', 12: 'right of way main',
  13: 'yield', 14: 'halt', 15: 'closed prohibited', 16: 'trucks hgv', 17: 'do not enter one way', 18: 'caution warning attention',
  19: 'bend', 20: 'bend', 21: 'bends winding', 22: 'bump bumpy', 23: 'skid', 25: 'construction roadworks', 26: 'signals',
  27: 'crosswalk zebra crossing', 28: 'school', 29: 'bicycles bikes', 31: 'deer', 32: 'derestricted', 33: 'right only', 34: 'left only',
  38: 'pass right', 39: 'pass left', 40: 'circle circular', 41: 'end of no passing', 42: 'end of no passing trucks hgv',
});

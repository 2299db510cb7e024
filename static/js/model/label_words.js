// @ts-check
/** What else people call the classes of signs, for the search: other words for the same thing, in lower case. */

/** @type {Readonly<Record<number, string>>} */
export const OTHER_WORDS = Object.freeze({
  6: 'derestricted', 9: 'no passing', 10: 'no passing trucks hgv', 11: 'right of way crossroads intersection', 12: 'right of way main',
  13: 'yield', 14: 'halt', 15: 'closed prohibited', 16: 'trucks hgv', 17: 'do not enter one way', 18: 'caution warning attention',
  19: 'bend', 20: 'bend', 21: 'bends winding', 22: 'bump bumpy', 23: 'skid', 25: 'construction roadworks', 26: 'signals',
  27: 'crosswalk zebra crossing', 28: 'school', 29: 'bicycles bikes', 31: 'deer', 32: 'derestricted', 33: 'right only', 34: 'left only',
  38: 'pass right', 39: 'pass left', 40: 'circle circular', 41: 'end of no passing', 42: 'end of no passing trucks hgv',
});

// @ts-check
/** Labels as the server sends them, for tests. */

/** @param {Partial<import('../../static/js/types.js').Label> & {id: number}} fields @returns {import('../../static/js/types.js').Label} */
export const label = (fields) => ({
  key: `key-${fields.id}`,
  name: `label ${fields.id}`,
  short: '',
  aliases: [],
  picture: null,
  shape: 'other',
  category: 'other',
  attributes: [],
  size_mm: null,
  mirror: null,
  teach: 'sign',
  colour: null,
  pinned: null,
  hidden: false,
  merged_into: null,
  ...fields,
});

/** @param {Partial<import('../../static/js/types.js').Attribute> & {name: string}} fields @returns {import('../../static/js/types.js').Attribute} */
export const attribute = (fields) => ({ kind: 'checkbox', mutable: false, values: [], low: null, high: null, default: null, ...fields });

/** Labels with these names, numbered from 0. @param {readonly string[]} names */
export const labelsNamed = (names) => names.map((name, id) => label({ id, key: name.replaceAll(' ', '-'), name }));

export const SPEED_LABELS = labelsNamed([
  'speed limit 20 km/h',
  'speed limit 30 km/h',
  'speed limit 80 km/h',
  'end of speed limit 80 km/h',
  'no overtaking',
  'stop',
]);

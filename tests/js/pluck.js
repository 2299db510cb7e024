// @ts-check
/** Fields of many items, for comparison. */

/**
 * One field of each item.
 * @template T
 * @template {keyof T} N
 * @param {readonly T[]|null|undefined} items
 * @param {N} name
 * @returns {T[N][]|undefined} undefined: there is no list
 */
export const pluck = (items, name) => items?.map((item) => item[name]);

/**
 * Some fields of each item.
 * @template T
 * @param {readonly T[]|null|undefined} items
 * @param {...keyof T} names
 * @returns {T[keyof T][][]|undefined}
 */
export const rowsOf = (items, ...names) => items?.map((item) => names.map((name) => item[name]));

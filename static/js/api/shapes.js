// @ts-check
/** Light checks of the server's answers, so that a wrong one is reported on arrival and not later in a view. */

import { plural } from '../model/format.js';
import { ApiError } from './errors.js';

/** @typedef {'string'|'number'|'boolean'|'array'|'object'|'nullable'} Kind */

/**
 * @param {string} place   for the message: `GET /videos`
 * @param {any} value
 * @param {Record<string, Kind>} fields
 * @returns {any} the value
 * @throws {ApiError} code `bad_answer`
 */
export function expectObject(place, value, fields) {
  if (!isObject(value)) throw wrong(place, 'an object', value);
  for (const [name, kind] of Object.entries(fields)) {
    if (!(name in value)) throw wrong(place, `a field '${name}'`, Object.keys(value));
    if (!matches(value[name], kind)) throw wrong(place, `'${name}' as ${kind}`, value[name]);
  }
  return value;
}

/**
 * @param {string} place
 * @param {any} value
 * @param {Record<string, Kind>} fields   checked in the first item only: the server makes all items in the same way
 * @returns {any[]}
 * @throws {ApiError} code `bad_answer`
 */
export function expectList(place, value, fields) {
  if (!Array.isArray(value)) throw wrong(place, 'a list', value);
  if (value.length) expectObject(`${place}[0]`, value[0], fields);
  return value;
}

/**
 * Check columns of equal length.
 *
 * @param {string} place
 * @param {any} value
 * @param {string[]} names
 * @returns {any}
 * @throws {ApiError} code `bad_answer`
 */
export function expectColumns(place, value, names) {
  expectObject(place, value, Object.fromEntries(names.map((name) => [name, /** @type {Kind} */ ('array')])));
  const length = value[names[0]].length;
  for (const name of names) {
    if (value[name].length !== length) {
      throw wrong(place, `${plural(length, 'entry', 'entries')} in column '${name}'`, value[name].length);
    }
  }
  return value;
}

/**
 * @param {unknown} value
 * @param {Kind} kind
 */
function matches(value, kind) {
  if (kind === 'nullable') return true;
  if (kind === 'array') return Array.isArray(value);
  if (kind === 'object') return isObject(value);
  return typeof value === kind;
}

/** @param {unknown} value */
function isObject(value) {
  return typeof value === 'object' && value !== null && !Array.isArray(value);
}

/**
 * @param {string} place
 * @param {string} expected
 * @param {unknown} got
 */
function wrong(place, expected, got) {
  const shown = JSON.stringify(got)?.slice(0, 80) ?? String(got);
  return new ApiError(
    0,
    'bad_answer',
    `${place}: expected ${expected}, got ${shown}. Page and server may be of different versions; reload the page.`,
  );
}

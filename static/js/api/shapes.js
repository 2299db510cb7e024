// @ts-check
/** Light checks of the server's answers, so that a wrong one is reported on arrival and not later in a view. */

import { plural } from '../model/format.js';
import { ApiError } from './errors.js';

/** @typedef {'string'|'number'|'boolean'|'array'|'object'|'nullable'} Kind */
/** @typedef {Readonly<Record<string, Kind>>} Fields */

/**
 * @param {string} route   for the message: `GET /videos`
 * @param {any} value
 * @param {Fields} fields
 * @returns {any} the value
 * @throws {ApiError} code `bad_answer`
 */
export function expectObject(route, value, fields) {
  if (!isObject(value)) throw unexpectedAnswer(route, 'an object', value);
  for (const [name, kind] of Object.entries(fields)) {
    if (!(name in value)) throw unexpectedAnswer(route, `a field '${name}'`, Object.keys(value));
    if (!matches(value[name], kind)) throw unexpectedAnswer(route, `'${name}' as ${kind}`, value[name]);
  }
  return value;
}

/**
 * @param {string} route
 * @param {any} value
 * @param {Fields} fields   checked in the first item only: the server makes all items in the same way
 * @returns {any[]}
 * @throws {ApiError} code `bad_answer`
 */
export function expectList(route, value, fields) {
  if (!Array.isArray(value)) throw unexpectedAnswer(route, 'a list', value);
  if (value.length) expectObject(`${route}[0]`, value[0], fields);
  return value;
}

/**
 * Check columns of equal length.
 *
 * @param {string} route
 * @param {any} value
 * @param {string[]} names
 * @returns {any}
 * @throws {ApiError} code `bad_answer`
 */
export function expectColumns(route, value, names) {
  expectObject(route, value, Object.fromEntries(names.map((name) => [name, /** @type {Kind} */ ('array')])));
  const length = value[names[0]].length;
  for (const name of names) {
    if (value[name].length !== length) {
      throw unexpectedAnswer(route, `${plural(length, 'entry', 'entries')} in column '${name}'`, value[name].length);
    }
  }
  return value;
}

/** @param {unknown} value @param {Kind} kind */
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

/** @param {string} route @param {string} expected @param {unknown} got */
function unexpectedAnswer(route, expected, got) {
  const shown = JSON.stringify(got)?.slice(0, 80) ?? String(got);
  return new ApiError(
    0,
    'bad_answer',
    `${route}: expected ${expected}, got ${shown}. Page and server may be of different versions; reload the page.`,
  );
}

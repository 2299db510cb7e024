// @ts-check
/** Heads of pages and tables. */

import { h } from './dom.js';

/** @typedef {import('./dom.js').Child} Child */

/**
 * The title of a page with a text beside it, and its buttons at the end of the line.
 *
 * @param {Child} title
 * @param {Child} beside   text beside the title; null: none
 * @param {...Child} controls
 */
export const pageHeading = (title, beside, ...controls) =>
  h(
    'div.library-head',
    h('h1', { dir: 'auto' }, title),
    typeof beside === 'string' ? h('span.muted', beside) : beside,
    controls.length > 0 && h('div.grow'),
    ...controls,
  );

/**
 * The header row of a table.
 *
 * @param {readonly (Child)[]} words   headers of text columns; false: omitted
 * @param {readonly (Child)[]} [numbers]   headers of the numeric columns after them
 */
export const tableHeading = (words, numbers = []) =>
  h(
    'thead',
    h(
      'tr',
      ...words.map((name) => name !== false && h('th', { scope: 'col' }, name)),
      ...numbers.map((name) => name !== false && h('th.number', { scope: 'col' }, name)),
    ),
  );

// @ts-check
/** The heads that pages and tables begin with. */

import { h } from './dom.js';

/** @typedef {import('./dom.js').Child} Child */

/**
 * The title of a page, what stands beside it, and its buttons at the other end of the line.
 *
 * @param {Child} title
 * @param {Child} beside   how much the page shows; null: nothing
 * @param {...Child} controls
 */
export const pageHead = (title, beside, ...controls) =>
  h(
    'div.library-head',
    h('h1', { dir: 'auto' }, title),
    typeof beside === 'string' ? h('span.muted', beside) : beside,
    controls.length > 0 && h('div.grow'),
    ...controls,
  );

/**
 * The row of names above the columns of a table.
 *
 * @param {readonly (Child)[]} words   those of the columns of words; false: left out
 * @param {readonly (Child)[]} [numbers]   those of the columns of numbers behind them
 */
export const tableHead = (words, numbers = []) =>
  h(
    'thead',
    h(
      'tr',
      ...words.map((name) => name !== false && h('th', { scope: 'col' }, name)),
      ...numbers.map((name) => name !== false && h('th.number', { scope: 'col' }, name)),
    ),
  );

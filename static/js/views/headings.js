// @ts-check
/** Heads of pages and tables. */

import { h } from './dom.js';

/** @typedef {import('./dom.js').Child} Child */

/**
 * The title of a page with a text beside it, and its buttons at the end of the line.
 *
 * @param {Child} title
 * @param {Child} subtitle   text beside the title; null: none
 * @param {...Child} controls
 */
export const pageHeading = (title, subtitle, ...controls) =>
  h(
    'div.library-head',
    h('h1', { dir: 'auto' }, title),
    typeof subtitle === 'string' ? h('span.muted', subtitle) : subtitle,
    controls.length > 0 && h('div.grow'),
    ...controls,
  );

/**
 * The header row of a table.
 *
 * @param {readonly (Child)[]} textColumns   headers of text columns; false: omitted
 * @param {readonly (Child)[]} [numberColumns]   headers of the numeric columns after them
 */
export const tableHeading = (textColumns, numberColumns = []) =>
  h(
    'thead',
    h(
      'tr',
      ...textColumns.map((name) => name !== false && h('th', { scope: 'col' }, name)),
      ...numberColumns.map((name) => name !== false && h('th.number', { scope: 'col' }, name)),
    ),
  );

// @ts-check
/** The confusion matrix: a table that is also a heat map; correct cells are on the diagonal. */

import { labelName, labelFor } from '../model/labels.js';
import { h } from './dom.js';
import { count, plural } from '../model/format.js';
import { imageWithPlaceholder } from './images.js';

/** @typedef {import('../api/compare-types.js').Comparison} Comparison */
/** @typedef {import('../api/compare-types.js').Cell} Cell */
/** @typedef {import('../api/compare-types.js').Places} Places */
/** @typedef {import('../types.js').Label} Label */

/**
 * Rows, columns and cells in table order; `null` means that the side has no box, and comes last.
 *
 * @param {Comparison['confusion']} confusion
 * @returns {{rows: (number|null)[], columns: (number|null)[], cell: (row: number|null, column: number|null) => Cell|undefined, maxCount: number}}
 */
export function arrangeConfusion({ classes, cells }) {
  /** @param {number|null} row @param {number|null} column */
  const keyOf = (row, column) => `${row}/${column}`;
  const cellsByKey = new Map(cells.map((cell) => [keyOf(cell.reference, cell.candidate), cell]));
  /** @param {(cell: Cell) => number|null} idOf @returns {(number|null)[]} */
  const axis = (idOf) => [
    ...classes.filter((id) => cells.some((cell) => idOf(cell) === id)),
    ...(cells.some((cell) => idOf(cell) === null) ? [null] : []),
  ];
  return {
    rows: axis((cell) => cell.reference),
    columns: axis((cell) => cell.candidate),
    cell: (row, column) => cellsByKey.get(keyOf(row, column)),
    maxCount: Math.max(1, ...cells.map((cell) => cell.count)),
  };
}

/**
 * The meaning of a cell, as the title of its places.
 * @param {Pick<Cell, 'reference'|'candidate'>} cell
 * @param {readonly Label[]} labels
 * @param {Record<string, string>} [engineNames]   models' names for signs that the set lacks
 */
export function describeCell({ reference, candidate }, labels, engineNames = {}) {
  /** @param {number|null} id */
  const name = (id) => engineNames[String(id)] ?? labelName(labels, id);
  if (candidate === null) return `${name(reference)}, missed`;
  return `${reference === null ? 'No sign' : name(reference)}, read as ${name(candidate)}`;
}

/** @param {Comparison} comparison @param {readonly Label[]} labels @param {(places: Places) => void} onShowPlaces @returns {HTMLElement} */
export function createConfusionMatrix(comparison, labels, onShowPlaces) {
  const { rows, columns, cell, maxCount } = arrangeConfusion(comparison.confusion);
  /** @param {number|null} id @param {string} absentText */
  const head = (id, absentText) => {
    const picture = labelFor(labels, id)?.picture;
    const text = id === null ? absentText : (comparison.confusion.words?.[String(id)] ?? labelName(labels, id));
    return h(
      'span.matrix-head',
      { title: text },
      picture && imageWithPlaceholder({ src: picture, width: 24, height: 24 }),
      h('span.truncate', text),
    );
  };
  /** @param {Cell} entry */
  const tone = (entry) => (entry.reference === entry.candidate ? 'right' : 'wrong');
  return h(
    'section.compare-confusion',
    { 'aria-labelledby': 'confusion-title' },
    h('h2', { id: 'confusion-title' }, 'Confusion of labels'),
    rows.length === 0
      ? h('p.muted', 'No boxes to compare in these frames.')
      : h(
          'div.matrix-frame',
          { role: 'region', 'aria-labelledby': 'confusion-title', tabIndex: 0 },
          h(
            'table.matrix',
            h('caption.muted.small', 'Rows: the reference. Columns: the candidate. Numbers: boxes.'),
            h('thead', h('tr', h('td'), ...columns.map((id) => h('th', { scope: 'col' }, head(id, 'missed'))))),
            h(
              'tbody',
              ...rows.map((row) =>
                h(
                  'tr',
                  h('th', { scope: 'row' }, head(row, 'nothing there')),
                  ...columns.map((column) => {
                    const entry = cell(row, column);
                    if (!entry) return h('td');
                    // A square root makes the few wrong cells visible beside many right ones.
                    const heat = Math.sqrt(entry.count / maxCount);
                    const description = describeCell(entry, labels, comparison.confusion.words);
                    const text = `${description}: ${plural(entry.count, 'box', 'boxes')}`;
                    return h(
                      'td',
                      {
                        class: `matrix-cell matrix-${tone(entry)} ${heat > 0.55 ? 'matrix-strong' : ''}`,
                        style: { '--heat-part': heat.toFixed(3) },
                      },
                      h(
                        'button',
                        {
                          title: text,
                          'aria-label': text,
                          onclick: () =>
                            onShowPlaces({
                              ...entry,
                              title: description,
                              side: entry.reference === null ? 'candidate' : 'reference',
                              places: entry.frames.length,
                            }),
                        },
                        count(entry.count),
                      ),
                    );
                  }),
                ),
              ),
            ),
          ),
        ),
  );
}

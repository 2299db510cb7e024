// @ts-check
/** The figures of a comparison as a table with bars. Each opens the places behind it. */

import { h } from './dom.js';
import { count, figure, percent, plural } from '../model/format.js';

/** @typedef {import('../api/compare-types.js').Comparison} Comparison */
/** @typedef {import('../api/compare-types.js').Figure} Figure */
/** @typedef {import('../api/compare-types.js').Places} Places */

/**
 * Name, name of its places, the side of their tracks, and an explanation.
 * @type {Record<string, [label: string, places: string, side: 'reference'|'candidate', text: string]>}
 */
const FIGURES = {
  precision: [
    'Precision',
    'False boxes',
    'candidate',
    'Share of the candidate’s boxes that match a box of the reference; boxes on ignored signs do not count.',
  ],
  recall: ['Recall', 'Missed boxes', 'reference', 'Share of the reference’s boxes that the candidate has; ignored boxes do not count.'],
  eq7: ['Localisation error (Eq. 7)', 'Largest errors', 'reference', 'Mean of 1 − intersection / larger area over the matches; 0 is best.'],
  coverage: ['Coverage', 'Uncovered stretches', 'reference', 'Share of the frames of each sign, from 20 px width, in which it is found.'],
  signs_found: ['Signs found', 'Signs never found', 'reference', 'Signs of at least 20 px that are found in at least one frame.'],
  signs_classified: ['Signs classified', 'Signs with a wrong label', 'reference', 'Found signs whose last label is correct.'],
  fragmentation: ['Fragmentation', 'Breaks', 'reference', 'How often a sign is lost and found again.'],
  switches: ['Identity switches', 'Switches', 'candidate', 'How often another track takes over a sign.'],
  ids_per_sign: ['Tracks per sign', 'Signs with a second track', 'reference', 'Mean number of tracks on one sign; 1 is best.'],
  false_tracks: ['False tracks', 'False tracks', 'candidate', 'Tracks of the candidate that overlap no sign.'],
};
/** Figures from 0 to 1, which have a bar. */
const SHARES = new Set(['precision', 'recall', 'eq7', 'coverage', 'signs_found', 'signs_classified']);

/** @param {Comparison} comparison @param {(places: Places) => void} onShowPlaces @returns {HTMLElement} */
export function createFigures(comparison, onShowPlaces) {
  const names = Object.keys(FIGURES).filter((name) => comparison.figures[name]);
  return h(
    'section.compare-figures',
    { 'aria-labelledby': 'figures-title' },
    h('h2', { id: 'figures-title' }, 'Figures'),
    h(
      'table.table.figures-table',
      h(
        'thead',
        h(
          'tr',
          h('th', { scope: 'col' }, 'Figure'),
          h('th.number', { scope: 'col' }, 'Value'),
          h('th', { scope: 'col' }, h('span.visually-hidden', 'Bar')),
          h('th.number', { scope: 'col' }, 'Of'),
          h('th', { scope: 'col' }, 'Places'),
        ),
      ),
      h('tbody', ...names.map((name) => row(name, comparison.figures[name], onShowPlaces))),
    ),
  );
}

/** @param {string} name @param {Figure} value @param {(places: Places) => void} onShowPlaces */
function row(name, value, onShowPlaces) {
  const [label, places, side, text] = FIGURES[name];
  const isShare = SHARES.has(name);
  const valueText = isShare && name !== 'eq7' ? percent(value.value) : figure(value.value);
  const ofText = value.of ? `${count(value.of[0])} / ${count(value.of[1])}` : '';
  const open = () => onShowPlaces({ title: places, side, ...value });
  /** A number that opens its places, if it has any. @param {string} text */
  const openableNumber = (text) =>
    value.places > 0 && text
      ? h(
          'button.figure-open',
          {
            title: `${places}: ${plural(value.places, 'place')}`,
            'aria-label': `${label} ${text}: ${places.toLowerCase()}`,
            onclick: open,
          },
          text,
        )
      : text;
  return h(
    'tr',
    h('th', { scope: 'row' }, h('div.stack.figure-name', h('span.figure-label', label), h('span.figure-text.muted.small', text))),
    h('td.number.figure-value', openableNumber(valueText)),
    h('td.figure-bar', isShare && value.value !== null && h('span.meter', { style: { '--part': `${value.value * 100}%` } }, h('span'))),
    h('td.number.muted.small.figure-of', openableNumber(ofText)),
    h(
      'td',
      value.places > 0
        ? h(
            'button.btn.btn-small',
            { 'aria-label': `${places}: ${plural(value.places, 'place')}`, onclick: open },
            plural(value.places, 'place'),
          )
        : h('span.muted.small', 'none'),
    ),
  );
}

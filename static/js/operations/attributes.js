// @ts-check
/** Attributes of the selected track. */

import { attributeRows } from '../model/attributes.js';
import { labelAt } from '../model/effective.js';
import { labelFor } from '../model/labels.js';
import { selectedDoc } from '../editing/revisions.js';
import { engineClass, selectedTrack } from '../review/shown_tracks.js';
import { toast } from '../core/toast.js';
import { editSelected, needsTrack, onReview, operation } from './helpers.js';

/** @typedef {import('../page-types.js').App} App */

const DIGITS = [1, 2, 3, 4, 5, 6, 7, 8, 9];

/**
 * The lines of the attribute form for the selected track at the cursor.
 * @param {import('../state-types.js').State} state
 * @returns {import('../model/attributes.js').AttributeRow[]}
 */
export function selectedAttributes(state) {
  const { review, labels } = state;
  const doc = selectedDoc(review);
  if (!review || !doc) return [];
  const id = labelAt(doc, review.frame, (track) => engineClass(review, track));
  return attributeRows(labelFor(labels, id), doc, review.frame);
}

/**
 * Set an attribute of the selected track. An engine's box stays the engine's, as with the mark "occluded".
 * @param {Pick<App, 'store'|'edit'>} app
 * @param {string} name
 * @param {import('../types.js').AttributeValue|null} value   null: removes it
 * @param {boolean} fromHere   from this frame on; otherwise in the whole track
 */
export function setAttribute(app, name, value, fromHere) {
  const shown = fromHere ? selectedTrack(app.store.get().review) : null;
  const box = shown === null || shown.origin === 'engine' ? {} : { box: shown.box };
  return editSelected(app, { name: 'attribute', attribute: name, value, from_here: fromHere, ...box });
}

/**
 * Check or uncheck a checkbox attribute of the selected track.
 * @param {Pick<App, 'store'|'edit'>} app
 * @param {number} digit
 * @param {import('../core/toast.js').Notify} [notify]
 */
export function toggleAttribute(app, digit, notify = toast) {
  const row = selectedAttributes(app.store.get()).find((one) => one.digit === digit);
  if (!row?.attribute) {
    notify(`The label has no checkbox ${digit}. Add attributes to it on the Labels page.`, { topic: 'attribute' });
    return;
  }
  const value = row.value !== true;
  const { mutable } = row.attribute;
  if (setAttribute(app, row.name, value, mutable))
    notify(`${row.name}: ${value ? 'yes' : 'no'}${mutable ? ', from this frame on' : ''}`, { topic: 'attribute' });
}

/** @type {import('../page-types.js').Operation[]} */
export const attributes = [
  operation({
    id: 'attribute',
    label: 'Check or uncheck a checkbox of the track',
    keys: DIGITS.map((digit) => `Alt+${digit}`),
    group: 'Verdict',
    each: true,
    disabled: needsTrack,
    available: (state) => onReview(state) && state.labels.some(({ attributes: own }) => own.some(({ kind }) => kind === 'checkbox')),
    tooltip: 'The checkboxes of the label in the inspector, in their order (Alt+1) to (Alt+9)',
    run: (app, key) => toggleAttribute(app, Number(String(key).slice(-1))),
  }),
];

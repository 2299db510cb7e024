// @ts-check
/** Somebody else has saved the same track first: both versions side by side, and a decision. */

import {h, setText} from '../dom.js';
import {sentence} from '../../api/errors.js';
import {trackName} from '../../model/track_name.js';

/** @typedef {import('../../types.js').TrackDoc} TrackDoc */
/** @typedef {import('../../types.js').Label} Label */

/** @type {Record<TrackDoc['review'], string>} */
const REVIEWS = {open: 'not reviewed', accepted: 'accepted', rejected: 'rejected', needs_work: 'needs work'};

/**
 * A version of a track as rows that can be compared.
 *
 * @param {TrackDoc|undefined} doc
 * @param {readonly Label[]} labels
 * @returns {Record<string, string>}
 */
export function describe(doc, labels) {
  if (!doc) return {State: 'not there'};
  const name = doc.class_id === null ? 'as the engine says' : labels.find(({id}) => id === doc.class_id)?.name ?? `class ${doc.class_id}`;
  const keys = Object.keys(doc.keys).map(Number).sort((a, b) => a - b);
  return {
    State: doc.merged_into ? `merged into ${trackName(doc.merged_into)}` : doc.gone ? 'deleted' : REVIEWS[doc.review],
    Class: name,
    'Is a sign': doc.not_a_sign ? 'no' : 'yes',
    Frames: doc.segments.map(({first, last}) => `${first}–${last}`).join(', ') || 'only drawn boxes',
    'Key frames': keys.length === 0 ? 'none' : keys.length > 8 ? `${keys.length}: ${keys[0]} … ${keys[keys.length - 1]}` : keys.join(', '),
    Notes: doc.notes.length === 0 ? 'none' : doc.notes.map((note) => `${note.author}: ${note.text}`).join('; '),
  };
}

/** Boxes that are shown of each version. */
const BOXES = 6;

/**
 * The key frames in which two versions differ, as rows of both.
 *
 * @param {TrackDoc|undefined} saved
 * @param {TrackDoc|undefined} own
 * @returns {[string, string, string][]} what, saved, own
 */
export function differingKeys(saved, own) {
  const frames = [...new Set([saved, own].flatMap((doc) => Object.keys(doc?.keys ?? {}).map(Number)))].sort((a, b) => a - b);
  /** @type {[string, string, string][]} */
  const rows = frames.map((frame) => [`Frame ${frame}`, keyText(saved, frame), keyText(own, frame)]);
  const differing = rows.filter(([, a, b]) => a !== b);
  const more = differing.length - BOXES;
  return more > 0 ? [...differing.slice(0, BOXES), ['More frames', `${more} differ`, `${more} differ`]] : differing;
}

/** @param {TrackDoc|undefined} doc @param {number} frame */
function keyText(doc, frame) {
  const key = doc?.keys[frame];
  if (key === undefined) return 'no key frame';
  const box = key.box === null ? 'the engine’s box' : `${key.box.map((edge) => Math.round(edge * 10) / 10).join(', ')}`;
  return [box, key.occluded && 'occluded', key.outside && 'outside', key.interpolate && 'interpolated on', key.class_id !== null && key.class_id !== undefined && 'its own class'].filter(Boolean).join('; ');
}

/**
 * @param {import('./layer.js').Setup} setup
 * @returns {import('./layer.js').Content}
 */
export function conflictDialog({app, data, close}) {
  const {labels} = app.store.get();
  /** @type {TrackDoc[]} */
  const current = data.current ?? [];
  /** @type {TrackDoc[]} */
  const yours = data.yours ?? [];
  const keys = [...new Set([...current, ...yours].map(({key}) => key))];
  const error = h('p', {class: 'field-error', role: 'alert', hidden: true});
  const theirs = h('button', {class: 'btn', type: 'button', onclick: () => act(data.takeTheirs)}, 'Take the saved version');
  const mine = h('button', {class: 'btn btn-primary', type: 'button', onclick: () => act(data.keepMine)}, 'Keep mine');

  /** @param {(() => unknown)|undefined} run */
  async function act(run) {
    try {
      await run?.();
      close();
    } catch (thrown) {
      error.hidden = false;
      setText(error, sentence(thrown));
    }
  }

  return {
    title: 'This track was changed in the meantime', size: 'middle', focus: theirs,
    body: h('div', {class: 'stack'},
      h('p', null, 'Another page has saved a change of the same track after you loaded it. Nothing is overwritten until you choose.'),
      ...keys.map((key) => versions(key, current.find((doc) => doc.key === key), yours.find((doc) => doc.key === key), labels)),
      h('p', {class: 'muted small'}, '“Keep mine” makes your change again on top of the saved version. “Take the saved version” drops it.'), error),
    footer: [h('button', {class: 'btn btn-quiet', type: 'button', onclick: close}, 'Decide later'), h('span', {class: 'grow'}), theirs, mine],
  };
}

/**
 * @param {string} key
 * @param {TrackDoc|undefined} current
 * @param {TrackDoc|undefined} yours
 * @param {readonly Label[]} labels
 */
function versions(key, current, yours, labels) {
  const [saved, own] = [describe(current, labels), describe(yours, labels)];
  const rows = [...new Set([...Object.keys(saved), ...Object.keys(own)])];
  return h('table', {class: 'table versions'},
    h('caption', null, `Track ${trackName(key, current ?? yours)}`),
    h('thead', null, h('tr', null, h('td'), h('th', {scope: 'col'}, `Saved${current ? ` (revision ${current.revision})` : ''}`), h('th', {scope: 'col'}, 'Yours'))),
    h('tbody', null, ...rows.map((row) => h('tr', {class: saved[row] === own[row] ? '' : 'differs'},
      h('th', {scope: 'row'}, row), h('td', null, saved[row] ?? '–'), h('td', null, own[row] ?? '–'))),
    ...differingKeys(current, yours).map(([what, theirs, mine]) => h('tr', {class: 'differs'}, h('th', {scope: 'row'}, what), h('td', null, theirs), h('td', null, mine)))));
}

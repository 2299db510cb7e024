// @ts-check
/** Key frames of the selected track, and the states between them. */

import { toast } from '../core/toast.js';
import { docOf } from '../editing/revisions.js';
import { keyAt, keyFramesOf } from '../model/documents.js';
import { shownSpan } from '../model/effective.js';
import { normalizeBox, sizeOf } from '../model/geometry.js';
import { knownBox } from '../review/known_box.js';
import { nearestBox } from '../review/nearest_box.js';
import { selectedTrack, shownTrack } from '../review/shown_tracks.js';
import { seek, setPlaying } from '../store/actions/review.js';
import { editSelected, needsLoadedBoxes, needsTrack } from './helpers.js';
import { editWithNotice } from './unseen.js';

/** @typedef {import('../page-types.js').App} App */
/** @typedef {import('../state-types.js').State} State */

/** The state that holds at the cursor. @param {State} state @param {'occluded'|'outside'} what */
function isSetAtCursor(state, what) {
  const { review } = state;
  const doc = review?.selected ? review.docs[review.selected] : undefined;
  return doc && review ? (keyAt(doc, review.frame)?.[what] ?? false) : false;
}

/**
 * Set a state of the selected track from here on. An engine's box stays the engine's: a key frame with a box is made
 * here only if a person drew the box, or if it is interpolated between two such boxes.
 *
 * @param {App} app
 * @param {'set_occluded'|'set_outside'} name
 * @param {'occluded'|'outside'} what
 */
export function toggleState(app, name, what) {
  const state = app.store.get();
  const shown = selectedTrack(state.review);
  const box = shown === null || shown.origin === 'engine' ? null : shown.box;
  editSelected(app, { name, value: !isSetAtCursor(state, what), box });
}

/** The two corrected key frames around the cursor. @param {State} state @returns {[number, number]|null} */
export function keyFramesAround(state) {
  const { review } = state;
  const doc = review?.selected ? review.docs[review.selected] : undefined;
  if (!doc || !review) return null;
  const frames = keyFramesOf(doc).filter((k) => doc.keys[k].box !== null);
  const first = frames.findLast((k) => k <= review.frame) ?? frames[0];
  const last = frames.find((k) => k > review.frame) ?? frames.at(-1);
  if (first === undefined || last === undefined) return null;
  if (first < last) return [first, last];
  const earlier = frames.at(-2);
  return earlier === undefined ? null : [earlier, last];
}

/**
 * Set or remove a key frame at the cursor. If the track has no box here, its nearest box is copied, with a notice.
 * @param {Pick<App, 'store'|'edit'> & Partial<Pick<App, 'editor'>>} app
 * @param {import('../core/toast.js').Notify} [notify]
 */
export function setKeyFrame(app, notify = toast) {
  const { review } = app.store.get();
  if (!review?.selected) return;
  const doc = docOf(review, review.selected);
  const shown = shownTrack(review, review.selected);
  const nearest = shown ? null : nearestBox(review, review.selected);
  if (shown && doc?.keys[review.frame]) editSelected(app, { name: 'remove_key' });
  else if (shown) editSelected(app, { name: 'add_key', box: shown.box });
  else if (nearest) {
    const box = normalizeBox(nearest.box, sizeOf(review.video));
    editWithNotice(app, review.selected, () => editSelected(app, { name: 'set_box', box }), { copied: nearest.frame, notify });
  }
}

/**
 * Interpolate the boxes between two key frames, or stop doing so. A drawn track is interpolated from the beginning, so
 * a notice says what has happened.
 *
 * @param {Pick<App, 'store'|'edit'> & Partial<Pick<App, 'editor'>>} app
 * @param {import('../core/toast.js').Notify} [notify]
 */
export function interpolate(app, notify = toast) {
  const state = app.store.get();
  const range = keyFramesAround(state);
  const key = state.review?.selected;
  const doc = key ? state.review?.docs[key] : undefined;
  if (!range || !key || !doc) return;
  const [first, last] = range;
  const value = !doc.keys[first].interpolate;
  const consequence = doc.segments.length ? 'The engine’s boxes are used again' : 'There are no boxes any more';
  const message = value
    ? `Boxes are interpolated between frames ${first} and ${last}.`
    : `${consequence} between frames ${first} and ${last}; press I again to interpolate.`;
  editWithNotice(app, key, () => editSelected(app, { name: 'interpolate', first, last, value }), { message, notify });
}

/**
 * The key frame that interpolation lacks: one here, or, if the only one is here, one at the other end of the track.
 * @param {State} state
 * @returns {number|null} its frame; null: none is lacking, or there is no such frame
 */
export function missingKeyFrame(state) {
  const { review } = state;
  if (needsTrack(state) !== null || !review?.selected || keyFramesAround(state)) return null;
  const doc = docOf(review, review.selected);
  if (!doc?.keys[review.frame]?.box) return review.frame;
  const span = shownSpan(doc, review.tracks);
  return span === null || span.first === span.last ? null : review.frame < span.last ? span.last : span.first;
}

/**
 * Go to the frame that lacks a key frame and set it.
 * @param {Pick<App, 'store'|'edit'> & Partial<Pick<App, 'editor'>>} app
 * @param {import('../core/toast.js').Notify} [notify]
 */
export function setMissingKeyFrame(app, notify = toast) {
  const state = app.store.get();
  const frame = missingKeyFrame(state);
  const key = state.review?.selected;
  if (frame === null || !key || !state.review) return;
  const box = knownBox(state.review, key, frame);
  if (frame !== state.review.frame) app.store.dispatch((now) => seek(setPlaying(now, false), frame));
  const why = needsLoadedBoxes(app.store.get());
  if (box) app.edit({ name: 'add_key', key, frame, box });
  else if (why) notify(`${why} Then press K.`, { topic: 'unseen' });
  else setKeyFrame(app, notify);
}

/** @param {number|null} frame   a frame that could become a key frame */
export const needsKeyFrames = (frame) => `Needs a key frame before and after.${frame === null ? '' : ` Set one at frame ${frame}?`}`;

/** @param {App} app */
export const keyFrameRemedy = (app) =>
  missingKeyFrame(app.store.get()) === null ? null : { label: 'Set key frame', run: () => setMissingKeyFrame(app) };

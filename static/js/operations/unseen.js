// @ts-check
/** Notices about edits that put boxes into frames in which neither the engine nor a person saw the sign. */

import { docOf } from '../editing/revisions.js';
import { lastFrameIn } from '../model/effective.js';
import { subtractSpans } from '../model/join.js';
import { countFrames, shownSpans } from '../model/shown_spans.js';
import { trackName } from '../model/track_name.js';
import { plural } from '../model/format.js';
import { toast } from '../core/toast.js';

/**
 * @typedef {import('../page-types.js').App} App
 * @typedef {import('../state-types.js').ReviewState} ReviewState
 * @typedef {import('../types.js').TrackDoc} TrackDoc
 */

/**
 * Ranges of frames in which a track shows something only after an edit.
 * @param {TrackDoc|null} before
 * @param {TrackDoc|null} after
 * @param {import('../types.js').TrackColumns|null} tracks
 */
export function gainedSpans(before, after, tracks) {
  /** @param {TrackDoc|null} doc */
  const runs = (doc) => (doc ? [...shownSpans(doc, lastFrameIn(tracks))] : []);
  return subtractSpans(runs(after), runs(before));
}

/**
 * The notice about boxes in frames in which nobody saw the sign.
 * @param {string} name                                                name of the track
 * @param {readonly import('../model/join.js').Span[]} runs            new ranges
 * @param {number} frame                                               frame of the edit; a box there is a person's
 * @param {number|null} copied                                         frame from which its box was copied; null: it was drawn
 * @returns {string} empty: no notice
 */
function unseenMessage(name, runs, frame, copied) {
  const messages = [];
  if (copied !== null)
    messages.push(`Track ${name} had no box in frame ${frame}: the box of frame ${copied} was copied here. Move it onto the sign.`);
  const others = subtractSpans([...runs], [[frame, frame]]);
  const frames = countFrames(others);
  if (frames > 0) {
    const [first, last] = [others[0][0], /** @type {import('../model/join.js').Span} */ (others.at(-1))[1]];
    messages.push(
      `In ${frames === 1 ? `frame ${first}` : `${plural(frames, 'frame')} (${first}–${last})`} the box is interpolated between key frames; nobody saw the sign there.`,
    );
  }
  return messages.join(' ');
}

/**
 * Make an edit of a track, with a notice if it puts boxes into frames in which nobody saw the sign.
 * @param {Pick<App, 'store'> & Partial<Pick<App, 'editor'>>} app
 * @param {string} key
 * @param {() => boolean} edit   returns whether the edit was made
 * @param {{copied?: number|null, message?: string, notify?: import('../core/toast.js').Notify}} [how]   copied: frame from which the box was copied; message: shown in any case
 * @returns {boolean} whether the edit was made
 */
export function editWithNotice(app, key, edit, { copied = null, message = '', notify = toast } = {}) {
  const before = app.store.get().review;
  if (!before || !edit()) return false;
  const after = app.store.get().review;
  if (!after) return true;
  const runs = gainedSpans(docOf(before, key), docOf(after, key), after.tracks);
  const text = [message, unseenMessage(trackName(key, after.docs[key]), runs, before.frame, copied)].filter(Boolean).join(' ');
  if (text) notify(text, { topic: 'unseen', action: { label: 'Undo', run: () => void app.editor?.undo() } });
  return true;
}

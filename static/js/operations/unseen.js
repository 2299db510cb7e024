// @ts-check
/** Notices about edits that put boxes into frames in which neither the engine nor a person saw the sign. */

import { docOf } from '../editing/revisions.js';
import { without } from '../model/join.js';
import { framesIn, shownRuns } from '../model/shown_runs.js';
import { trackName } from '../model/track_name.js';
import { plural } from '../model/format.js';
import { toast } from '../core/toast.js';

/**
 * @typedef {import('../page-types.js').App} App
 * @typedef {import('../state-types.js').ReviewState} ReviewState
 * @typedef {import('../types.js').TrackDoc} TrackDoc
 * @typedef {(text: string, options?: import('../core/toast.js').ToastOptions) => void} Say
 */

/**
 * Ranges of frames in which a track shows something only after an edit.
 * @param {TrackDoc|null} before
 * @param {TrackDoc|null} after
 * @param {import('../types.js').TrackColumns|null} tracks
 */
export function gained(before, after, tracks) {
  const lastOf = (/** @type {number} */ id) => tracks?.last[tracks.id.indexOf(id)] ?? null;
  /** @param {TrackDoc|null} doc */
  const runs = (doc) => (doc ? [...shownRuns(doc, lastOf)] : []);
  return without(runs(after), runs(before));
}

/**
 * The notice about boxes in frames in which nobody saw the sign.
 * @param {string} name                                                name of the track
 * @param {readonly import('../model/join.js').Span[]} runs            new ranges
 * @param {number} frame                                               frame of the edit; a box there is a person's
 * @param {number|null} copied                                         frame from which its box was copied; null: it was drawn
 * @returns {string} empty: no notice
 */
function unseenWords(name, runs, frame, copied) {
  const words = [];
  if (copied !== null)
    words.push(`Track ${name} had no box in frame ${frame}: the box of frame ${copied} was copied here. Move it onto the sign.`);
  const others = without([...runs], [[frame, frame]]);
  const frames = framesIn(others);
  if (frames > 0) {
    const [first, last] = [others[0][0], /** @type {import('../model/join.js').Span} */ (others.at(-1))[1]];
    words.push(
      `In ${frames === 1 ? `frame ${first}` : `${plural(frames, 'frame')} (${first}–${last})`} the box is interpolated between key frames; nobody saw the sign there.`,
    );
  }
  return words.join(' ');
}

/**
 * Make an edit of a track, with a notice if it puts boxes into frames in which nobody saw the sign.
 * @param {Pick<App, 'store'> & Partial<Pick<App, 'editor'>>} app
 * @param {string} key
 * @param {() => boolean} edit   returns whether the edit was made
 * @param {{copied?: number|null, said?: string, say?: Say}} [how]   copied: frame from which the box was copied; said: text to show in any case
 * @returns {boolean} whether the edit was made
 */
export function editWithNotice(app, key, edit, { copied = null, said = '', say = toast } = {}) {
  const before = app.store.get().review;
  if (!before || !edit()) return false;
  const after = app.store.get().review;
  if (!after) return true;
  const runs = gained(docOf(before, key), docOf(after, key), after.tracks);
  const words = [said, unseenWords(trackName(key, after.docs[key]), runs, before.frame, copied)].filter(Boolean).join(' ');
  if (words) say(words, { topic: 'unseen', action: { label: 'Undo', run: () => void app.editor?.undo() } });
  return true;
}

// @ts-check
/** Names of commands. */

import { plural } from '../model/format.js';
import { trackName } from '../model/track_name.js';

/** Commands about a whole track: their frame does not matter. */
const TRACK_COMMANDS = new Set([
  'relabel_track',
  'delete_track',
  'restore_track',
  'merge',
  'set_not_a_sign',
  'ignore',
  'set_review',
  'adopt',
]);

/** Commands about several tracks: their first track does not matter. */
const MULTI_TRACK_COMMANDS = new Set(['review_tracks', 'edit_tracks', 'import', 'import_bundle', 'take_over']);

/** @type {Record<string, string>} */
const NAMES = {
  create_track: 'New track',
  set_box: 'Box corrected',
  relabel_track: 'Track relabelled',
  relabel_box: 'Box relabelled',
  merge: 'Tracks merged',
  split: 'Track split',
  delete_from: 'Track cut off',
  delete_track: 'Track deleted',
  restore_track: 'Track restored',
  add_key: 'Key frame set',
  remove_key: 'Key frame removed',
  interpolate: 'Line between boxes changed',
  follow: 'Track followed',
  set_occluded: 'Occlusion marked',
  set_outside: 'Outside marked',
  set_not_a_sign: 'Verdict',
  ignore: 'Region to ignore marked',
  attribute: 'Attribute changed',
  set_review: 'Verdict',
  review_tracks: 'Verdict on several tracks',
  edit_tracks: 'Several tracks changed',
  add_note: 'Note pinned',
  edit_note: 'Note changed',
  remove_note: 'Note removed',
  import: 'Import',
  import_bundle: 'Bug bundle opened',
  take_over: 'Ground truth taken over',
  adopt: 'Track taken over',
  undo: 'Undo',
  redo: 'Redo',
};

/** Why no edit is possible between two reviews. */
export const STILL_OPENING = 'the review is still being opened. Try again in a moment';

/** @param {string} name of a command @returns {string} */
export const commandName = (name) => NAMES[name] ?? name;

/**
 * What an undo or redo was about, as the continuation of "Undone: ".
 *
 * @param {string} name        of the command
 * @param {number|null} frame
 * @param {string} [track]     its name from `trackName`
 * @param {number} [tracks]    number of affected tracks; 0: not known
 * @returns {string}
 */
export function describeUndone(name, frame, track, tracks = 0) {
  const what = commandName(name).toLowerCase();
  if (name === 'import' && tracks > 0) return `${what} of ${plural(tracks, 'track')}`;
  if (MULTI_TRACK_COMMANDS.has(name)) return what;
  if (TRACK_COMMANDS.has(name)) return track === undefined ? what : `${what}, track ${track}`;
  return frame === null ? what : `${what} in frame ${frame}`;
}

/**
 * A sentence with the names of tracks in place of their keys, which model and server use.
 *
 * @param {string} message
 * @param {Record<string, import('../types.js').TrackDoc>} docs
 * @returns {string}
 */
export function withTrackNames(message, docs) {
  return message.replace(/\b([Tt]rack) (m\d+|h[0-9a-f]{8,})\b/g, (_, word, key) => `${word} ${trackName(key, docs[key])}`);
}

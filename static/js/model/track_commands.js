// @ts-check
/**
 * Merging tracks and splitting a track. Pure. The twin of a part of app/edits/apply.py.
 *
 * @typedef {import('../types.js').Command} Command
 * @typedef {import('../types.js').TrackDoc} TrackDoc
 */
import { CommandError, requireValue } from './command_error.js';
import {
  OPEN_END,
  originTrack,
  blankDoc,
  clipSegments,
  isEmpty,
  keyAt,
  keysWithin,
  lineEnds,
  newKeyFrame,
  nonDefaultFields,
  stateOf,
  withKey,
} from './documents.js';
import { join } from './join.js';

/**
 * @param {Record<string, TrackDoc>} docs
 * @param {TrackDoc} doc
 * @param {Command} command
 * @returns {Record<string, TrackDoc>}
 */
export function merge(docs, doc, command) {
  /** @type {Record<string, TrackDoc>} */
  const changed = {};
  const origin = originTrack(doc);
  for (const key of new Set(command.others ?? [])) {
    const other = docs[key];
    if (!other || other.gone || key === doc.key) {
      throw new CommandError(`Track ${key} cannot be merged: it is gone, or the same track.`);
    }
    doc = join(doc, other, command.gaps);
    changed[key] = { ...other, gone: true, merged_into: doc.key };
  }
  // an earlier segment must not change the label
  if (doc.class_id === null && originTrack(doc) !== origin) doc = { ...doc, class_id: command.class_id ?? null };
  return { [doc.key]: doc, ...changed };
}

/**
 * @param {Record<string, TrackDoc>} docs
 * @param {TrackDoc} doc
 * @param {Command} command
 * @returns {Record<string, TrackDoc>}
 */
export function split(docs, doc, command) {
  const { frame } = command;
  const origin = originTrack(doc);
  const newKey = requireValue(command.new_key, 'new_key');
  if (docs[newKey]) throw new CommandError(`There is a track ${newKey} already.`);
  for (const [end, box] of lineEnds(doc, frame)) doc = withKey(doc, end, { box });
  const later = keysWithin(doc, frame, Infinity);
  if (!doc.keys[frame]) {
    const state = stateOf(keyAt(doc, frame));
    if (state.occluded || state.outside || state.attributes) later[frame] = newKeyFrame({ ...state, interpolate: false });
  }
  /** @type {TrackDoc} */
  const laterDoc = {
    ...blankDoc(newKey),
    class_id: doc.class_id,
    not_a_sign: doc.not_a_sign,
    ...nonDefaultFields(doc),
    segments: clipSegments(doc.segments, frame, OPEN_END),
    keys: later,
    notes: doc.notes.filter((n) => n.frame >= frame),
  };
  const earlierDoc = {
    ...doc,
    segments: clipSegments(doc.segments, -1, frame - 1),
    keys: keysWithin(doc, -1, frame - 1),
    notes: doc.notes.filter((n) => n.frame < frame),
  };
  if (isEmpty(earlierDoc) || isEmpty(laterDoc)) {
    throw new CommandError(`Track ${doc.key} has nothing on one side of frame ${frame}. Split it in between.`);
  }
  const class_id = command.class_id ?? null;
  const halves = [earlierDoc, laterDoc].map((half) =>
    half.class_id === null && originTrack(half) !== origin ? { ...half, class_id } : half,
  );
  return Object.fromEntries(halves.map((half) => [half.key, half]));
}

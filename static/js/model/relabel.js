// @ts-check
/**
 * Another class for a whole track. The twin of app/edits/relabel.py; pure.
 *
 * @typedef {import('../types.js').KeyFrame} KeyFrame
 * @typedef {import('../types.js').TrackDoc} TrackDoc
 */
import { keyFramesOf } from './documents.js';

/**
 * The whole track means every box: labels of single ones go, and key frames that said nothing else with them.
 * @param {TrackDoc} doc
 * @param {number|null} class_id   null: the engine's
 * @returns {TrackDoc}
 */
export function relabelled(doc, class_id) {
  /** @type {Record<string, KeyFrame>} */
  const keys = {};
  /** @type {Omit<KeyFrame, 'box'|'class_id'>} */
  let held = { occluded: false, outside: false, interpolate: false };
  for (const frame of keyFramesOf(doc)) {
    const key = doc.keys[frame];
    const says = key.box !== null || key.occluded !== held.occluded || key.outside !== held.outside || key.interpolate !== held.interpolate;
    if (key.class_id !== null && !says) continue;
    keys[frame] = { ...key, class_id: null };
    held = key;
  }
  return { ...doc, class_id, keys };
}

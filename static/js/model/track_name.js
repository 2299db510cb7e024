// @ts-check
/**
 * Names of tracks on the screen. Keys (`m7`, `h0c4f…`) are internal. Pure.
 *
 * @typedef {import('../types.js').TrackDoc} TrackDoc
 */
import { keyFramesOf } from './documents.js';

/**
 * An engine track is named by its number, a track that a person made by its origin: `#7`, `#7 from 120` after a split,
 * `drawn at 88`. The name follows the word "track".
 *
 * @param {string} key
 * @param {TrackDoc} [doc]   its document; without it, a person's track is `made by hand`
 * @returns {string}
 */
export function trackName(key, doc) {
  if (key.startsWith('m')) return `#${key.slice(1)}`;
  const piece = doc?.segments[0];
  if (piece) return `#${piece.track} from ${piece.first}`;
  const first = doc && keyFramesOf(doc)[0];
  return first === undefined ? 'made by hand' : `drawn at ${first}`;
}

/** The first of many names, and the number of the rest. @param {readonly string[]} names @param {number} maxCount */
export const listNames = (names, maxCount) =>
  names.slice(0, maxCount).join(', ') + (names.length > maxCount ? ` and ${names.length - maxCount} more` : '');

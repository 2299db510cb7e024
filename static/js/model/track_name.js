// @ts-check
/**
 * What a track is called wherever people read it. Keys (`m7`, `h0c4f…`) are for the program. Pure.
 *
 * @typedef {import('../types.js').TrackDoc} TrackDoc
 */
import { keyFramesOf } from './documents.js';

/**
 * An engine's track by its number; one that a person made by where it comes from: `#7`, `#7 from 120` after a split,
 * `drawn at 88`. It reads on after the word "track".
 *
 * @param {string} key
 * @param {TrackDoc} [doc]   its document; without one, a person's track is just `made by hand`
 * @returns {string}
 */
export function trackName(key, doc) {
  if (key.startsWith('m')) return `#${key.slice(1)}`;
  const piece = doc?.segments[0];
  if (piece) return `#${piece.track} from ${piece.first}`;
  const first = doc && keyFramesOf(doc)[0];
  return first === undefined ? 'made by hand' : `drawn at ${first}`;
}

/**
 * The first names of many, and how many more there are.
 * @param {readonly string[]} names
 * @param {number} most
 */
export const listed = (names, most) => names.slice(0, most).join(', ') + (names.length > most ? ` and ${names.length - most} more` : '');

// @ts-check
/** Merge mode: clicks mark the tracks to merge. The selected track is marked at the start. */

import { listNames, trackName } from '../model/track_name.js';

/** @type {import('./index.js').Mode} */
export const merge = {
  enter: ({ selected }) => ({ marked: selected ? [selected] : [] }),
  exit: () => ({ marked: [] }),
  changesBoxes: false,
  cursor: null,
  onTrackClick: ({ marked }, key) => ({ marked: marked.includes(key) ? marked.filter((other) => other !== key) : [...marked, key] }),
  hint({ marked, docs }) {
    const names = listNames(
      marked.map((key) => trackName(key, docs[key])),
      5,
    );
    if (marked.length === 0) return 'Click the tracks to merge, then press M. Escape ends.';
    if (marked.length === 1) return `Track ${names} is marked: click the others, then press M. Escape ends.`;
    return `Tracks ${names} are marked: press M to merge them into the first, or click more. Escape ends.`;
  },
};

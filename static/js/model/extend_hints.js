// @ts-check
/**
 * The ends of a track at which its sign may be visible further, and the key that looks there: only following tells
 * whether it is. Pure.
 */

/** A sign whose first box is this wide may have been visible before, px. */
const WIDE = 20;
/** A box closer than this to the picture's edge is leaving the picture, px. */
const EDGE = 4;

/**
 * @param {import('../types.js').TrackColumns|null} tracks
 * @param {import('./track_entries.js').TrackEntry} entry
 * @param {{width: number, height: number, frames: number}} video
 * @returns {string} empty: neither end is such
 */
export function extendHint(tracks, entry, { width, height, frames }) {
  if (tracks === null || !entry.whole) return '';
  const first = tracks.first_box?.[entry.column] ?? null;
  const last = tracks.last_box?.[entry.column] ?? null;
  /** @param {import('../types.js').Box} box */
  const isInside = ([x1, y1, x2, y2]) => x1 > EDGE && y1 > EDGE && x2 < width - EDGE && y2 < height - EDGE;
  const words = [];
  if (first && entry.first > 0 && first[2] - first[0] >= WIDE && isInside(first))
    words.push(`Begins ${Math.round(first[2] - first[0])} px wide, perhaps too late (, looks further back).`);
  if (last && entry.last < frames - 1 && isInside(last)) words.push('Ends inside the picture, perhaps too early (. looks further on).');
  return words.join(' ');
}

// @ts-check
/**
 * The ends of a track at which its sign may be visible further, and the key that looks there: only following tells
 * whether it is. Pure.
 */

/** A sign whose first box is this wide may have been visible before, px. */
const MIN_WIDTH_PX = 20;
/** A box closer than this to the picture's edge is leaving the picture, px. */
const EDGE_MARGIN_PX = 4;

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
  const isInside = ([x1, y1, x2, y2]) =>
    x1 > EDGE_MARGIN_PX && y1 > EDGE_MARGIN_PX && x2 < width - EDGE_MARGIN_PX && y2 < height - EDGE_MARGIN_PX;
  const hints = [];
  if (first && entry.first > 0 && first[2] - first[0] >= MIN_WIDTH_PX && isInside(first))
    hints.push(`Begins ${Math.round(first[2] - first[0])} px wide, perhaps too late: press , to look further back.`);
  if (last && entry.last < frames - 1 && isInside(last))
    hints.push('Ends inside the picture, perhaps too early: press . to look further on.');
  return hints.join(' ');
}

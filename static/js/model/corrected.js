// @ts-check
/** Whether people have changed a track. Pure. */

/**
 * Whether a track differs from the engine's. After everything is undone it does not.
 * @param {import('../types.js').TrackDoc} doc
 * @param {import('../types.js').TrackColumns|null} tracks
 */
export function isCorrected(doc, tracks) {
  const at = doc.key.startsWith('m') && tracks ? tracks.id.indexOf(Number(doc.key.slice(1))) : -1;
  const [piece, ...others] = doc.segments;
  const isEngineTrack =
    tracks !== null &&
    at >= 0 &&
    others.length === 0 &&
    piece !== undefined &&
    piece.track === tracks.id[at] &&
    piece.first <= tracks.first[at] &&
    piece.last >= tracks.last[at];
  return !isEngineTrack || doc.gone || doc.class_id !== null || doc.not_a_sign || Object.keys(doc.keys).length > 0;
}

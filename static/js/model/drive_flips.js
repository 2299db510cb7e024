// @ts-check
/** The tracks of a drive whose gate verdicts would flip at another tau, with people's corrections. Pure. */

/**
 * @typedef {import('../types.js').Flips} Flips
 * @typedef {import('../types.js').TrackDoc} TrackDoc
 * @typedef {{key: string, frame: number, flips: number}} FlippedTrack   a track, the first frame in which a verdict flips, and the number of flips
 */

/**
 * Tracks with flipped verdicts, in frame order. Deleted tracks are left out.
 *
 * @param {Flips} flips
 * @param {Record<string, TrackDoc>} docs
 * @returns {FlippedTrack[]}
 */
export function flippedTracks(flips, docs) {
  const places = flips.tracks.flatMap(({ id, frame, flips: count }) => {
    const key = keyOf(id, frame, docs);
    return key === null ? [] : [{ key, frame, flips: count }];
  });
  return places.sort((a, b) => a.frame - b.frame || (a.key < b.key ? -1 : 1));
}

/**
 * The next place after the selected track's last one; after the last place, the first one. If the selected track has no
 * place, the next one in time. A track may have several places, because it may be merged from others.
 *
 * @param {readonly FlippedTrack[]} places   in frame order
 * @param {string|null} selected
 * @param {number} frame   frame of the cursor
 * @returns {FlippedTrack|null} null: none
 */
export function nextFlippedTrack(places, selected, frame) {
  const passed = places.filter((place) => place.key === selected && place.frame <= frame);
  const at = passed.length === 0 ? -1 : places.indexOf(passed[passed.length - 1]);
  const next = at < 0 ? places.find((place) => place.frame > frame) : places[at + 1];
  return next ?? places[0] ?? null;
}

/** Key of the track that contains an engine track in a frame. @param {number} id @param {number} frame @param {Record<string, TrackDoc>} docs */
function keyOf(id, frame, docs) {
  const own = docs[`m${id}`];
  if (own === undefined) return `m${id}`;
  const holder = Object.values(docs).find(
    (doc) => !doc.gone && doc.segments.some((part) => part.track === id && part.first <= frame && frame <= part.last),
  );
  return holder?.key ?? null;
}

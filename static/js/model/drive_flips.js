// @ts-check
/** The tracks of a drive whose verdicts another tau would turn over, as people have left them. Pure. */

/**
 * @typedef {import('../types.js').Flips} Flips
 * @typedef {import('../types.js').TrackDoc} TrackDoc
 * @typedef {{key: string, frame: number, flips: number}} Place   a track, the first frame in which a verdict flips, and how many do
 */

/**
 * Places to look at, in the order of the drive. Tracks that a person took away have none.
 *
 * @param {Flips} flips
 * @param {Record<string, TrackDoc>} docs
 * @returns {Place[]}
 */
export function flippedPlaces(flips, docs) {
  const places = flips.tracks.flatMap(({ id, frame, flips: many }) => {
    const key = keyOf(id, frame, docs);
    return key === null ? [] : [{ key, frame, flips: many }];
  });
  return places.sort((a, b) => a.frame - b.frame || (a.key < b.key ? -1 : 1));
}

/**
 * The place after the selected track's latest, the first one after the last; where the track has none yet, the next in
 * time. A track may have several: it may have been joined from others.
 *
 * @param {readonly Place[]} places   in the order of the drive
 * @param {string|null} selected
 * @param {number} frame   of the cursor
 * @returns {Place|null} null: there is none
 */
export function nextPlace(places, selected, frame) {
  const passed = places.filter((place) => place.key === selected && place.frame <= frame);
  const at = passed.length === 0 ? -1 : places.indexOf(passed[passed.length - 1]);
  const next = at < 0 ? places.find((place) => place.frame > frame) : places[at + 1];
  return next ?? places[0] ?? null;
}

/** The track that shows the engine's track in a frame. @param {number} id @param {number} frame @param {Record<string, TrackDoc>} docs */
function keyOf(id, frame, docs) {
  const own = docs[`m${id}`];
  if (own === undefined) return `m${id}`;
  const holder = Object.values(docs).find(
    (doc) => !doc.gone && doc.segments.some((part) => part.track === id && part.first <= frame && frame <= part.last),
  );
  return holder?.key ?? null;
}

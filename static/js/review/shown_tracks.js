// @ts-check
/**
 * What is in a frame once the corrections are applied: the boxes that can be selected and edited. Pure.
 *
 * @typedef {import('../types.js').ReviewState} ReviewState
 * @typedef {import('../types.js').Box} Box
 *
 * @typedef {object} ShownTrack
 * @property {string} key
 * @property {Box} box
 * @property {'engine'|'corrected'|'interpolated'} origin
 * @property {boolean} occluded
 * @property {number|null} class_id
 * @property {boolean} edited          a person has touched the track
 * @property {import('../types.js').OverlayTrack|null} engine
 */
import { boxAt } from '../model/effective.js';

/**
 * @param {ReviewState} review
 * @param {number} [frame]   unset: the cursor's
 * @returns {ShownTrack[]} unedited tracks first
 */
export function shownTracks(review, frame = review.frame) {
  const overlay = review.overlays[frame];
  const engine = new Map((overlay?.tracks ?? []).map((track) => [track.id, track]));
  /** @param {number} id */
  const machineBox = (id) => engine.get(id)?.box ?? null;
  const classes = classesOf(review);
  /** @type {ShownTrack[]} */
  const shown = [];
  for (const track of engine.values()) {
    const key = `m${track.id}`;
    // a track that is confirmed later is shown from its first frame on
    if (review.docs[key] || !(classes.has(track.id) || track.state === 'confirmed')) continue;
    shown.push({ key, box: track.box, origin: 'engine', occluded: false, class_id: classes.get(track.id) ?? track.class_id, edited: false, engine: track });
  }
  for (const doc of Object.values(review.docs)) {
    const at = boxAt(doc, frame, machineBox, (id) => classes.get(id) ?? null);
    if (at === null) continue;
    const segment = doc.segments.find(({ first, last }) => first <= frame && frame <= last);
    shown.push({ key: doc.key, ...at, edited: true, engine: (segment && engine.get(segment.track)) ?? null });
  }
  return shown;
}

/** The track's box in a frame; null: none. @param {ReviewState} review @param {string} key @param {number} [frame] @returns {ShownTrack|null} */
export const shownTrack = (review, key, frame = review.frame) => shownTracks(review, frame).find((track) => track.key === key) ?? null;

/** @type {WeakMap<object, Map<number, number|null>>} */
const known = new WeakMap();

/** Fused class of each engine track. @param {ReviewState} review @returns {Map<number, number|null>} */
function classesOf(review) {
  if (review.tracks === null) return new Map();
  let classes = known.get(review.tracks);
  if (!classes) {
    const { id, class_id } = review.tracks;
    classes = new Map(id.map((track, at) => [track, class_id[at]]));
    known.set(review.tracks, classes);
  }
  return classes;
}

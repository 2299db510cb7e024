// @ts-check
/**
 * The boxes of a frame after corrections, which can be selected and edited. Pure.
 *
 * @typedef {import('../state-types.js').ReviewState} ReviewState
 * @typedef {import('../types.js').Box} Box
 *
 * @typedef {object} ShownTrack
 * @property {string} key
 * @property {Box} box
 * @property {'engine'|'corrected'|'interpolated'|'proposed'} origin   proposed: from a follow, not accepted yet
 * @property {boolean} occluded
 * @property {number|null} class_id     null: not known; -1: none of the classes, given by a person
 * @property {string|null} word        the engine's name for it, if that is its label and the set has no such label
 * @property {boolean} not_a_sign      marked by a person
 * @property {boolean} edited          a person has changed the box, its label or its occlusion
 * @property {import('../types.js').OverlayTrack|null} engine
 */
import { isCorrected } from '../model/corrected.js';
import { NO_CLASS, originTrack } from '../model/documents.js';
import { boxAt } from '../model/effective.js';
import { proposalAt } from '../model/following.js';
import { covers } from '../model/run_progress.js';

/**
 * @param {ReviewState} review
 * @param {number} [frame]   unset: the cursor's
 * @returns {ShownTrack[]} unedited tracks first
 */
export function shownTracks(review, frame = review.frame) {
  const overlay = review.overlays[frame];
  const engine = new Map((overlay?.tracks ?? []).map((track) => [track.id, track]));
  /** @param {number} id */
  const engineBox = (id) => engine.get(id)?.box ?? null;
  const classes = classesOf(review);
  /** @type {ShownTrack[]} */
  const shown = [];
  for (const track of engine.values()) {
    const key = `m${track.id}`;
    // a track that is confirmed later is shown from its first frame on
    if (review.docs[key] || !(classes.has(track.id) || track.state === 'confirmed')) continue;
    shown.push({
      key,
      box: track.box,
      origin: 'engine',
      occluded: false,
      class_id: classes.get(track.id) ?? track.class_id,
      word: engineWord(review, track.id) ?? track.word ?? null,
      not_a_sign: false,
      edited: false,
      engine: track,
    });
  }
  for (const doc of Object.values(review.docs)) {
    const at = boxAt(doc, frame, engineBox, (id) => classes.get(id) ?? null);
    if (at === null) continue;
    const segment = doc.segments.find(({ first, last }) => first <= frame && frame <= last);
    const originalTrack = at.class_id === NO_CLASS && doc.class_id === null && doc.keys[frame]?.class_id == null ? originTrack(doc) : null;
    shown.push({
      key: doc.key,
      ...at,
      word: originalTrack === null ? null : engineWord(review, originalTrack),
      not_a_sign: doc.not_a_sign,
      edited: isEdited(at, doc, segment ? (classes.get(segment.track) ?? null) : null),
      engine: (segment && engine.get(segment.track)) ?? null,
    });
  }
  return withProposal(review, frame, shown, classes);
}

/**
 * The proposed box of a followed track replaces its own and can be selected and corrected like any other.
 * @param {ReviewState} review
 * @param {number} frame
 * @param {ShownTrack[]} shown
 * @param {Map<number, number|null>} classes
 * @returns {ShownTrack[]}
 */
function withProposal(review, frame, shown, classes) {
  const { following } = review;
  const proposal = following ? proposalAt(following, frame) : null;
  if (!following || !proposal || proposal.source === 'anchor') return shown;
  const replaced = shown.find(({ key }) => key === following.key);
  const doc = review.docs[following.key];
  const class_id = replaced?.class_id ?? doc?.class_id ?? classes.get(Number(following.key.slice(1))) ?? null;
  /** @type {ShownTrack} */
  const proposed = {
    key: following.key,
    box: proposal.box,
    origin: 'proposed',
    occluded: false,
    class_id,
    word: replaced?.word ?? null,
    not_a_sign: doc?.not_a_sign ?? false,
    edited: true,
    engine: replaced?.engine ?? null,
  };
  return [...shown.filter((one) => one !== replaced), proposed];
}

/**
 * Whether a box differs from the engine's. A track with one corrected frame has the engine's boxes in all other frames,
 * and so has a track that was split or merged. A label of the whole track counts for each of its boxes.
 *
 * @param {import('../model/effective.js').EffectiveBox} at
 * @param {import('../types.js').TrackDoc} doc
 * @param {number|null} engineClassId   the engine's class of the box's track
 */
const isEdited = (at, doc, engineClassId) => at.origin !== 'engine' || at.occluded || doc.not_a_sign || at.class_id !== engineClassId;

/** The signs of the second run in the cursor's frame. @param {ReviewState} review */
export function secondRunSigns(review) {
  if (review.second === null) return [];
  const secondReview = { ...review, overlays: review.secondOverlays, tracks: review.secondTracks, docs: review.secondDocs };
  return shownSigns(secondReview);
}

/** The tracks without rejected ones, which count nowhere. @param {ReviewState} review */
export const shownSigns = (review) =>
  shownTracks(review).filter(({ key, not_a_sign }) => !not_a_sign && review.docs[key]?.review !== 'rejected');

/**
 * Keys of tracks that people have accepted, rejected or corrected. Notes alone do not count.
 * @param {ReviewState} review
 * @returns {string[]}
 */
export const correctedKeys = (review) =>
  Object.values(review.docs)
    .filter(
      (doc) =>
        doc.merged_into === null &&
        (doc.key.startsWith('m') || !doc.gone) &&
        (doc.review === 'accepted' || doc.review === 'rejected' || isCorrected(doc, review.tracks)),
    )
    .map(({ key }) => key);

/** The track's box in a frame; null: none. @param {ReviewState} review @param {string} key @param {number} [frame] @returns {ShownTrack|null} */
export const shownTrack = (review, key, frame = review.frame) => shownTracks(review, frame).find((track) => track.key === key) ?? null;

/** The selected track's box in the cursor's frame; null: none. @param {ReviewState|null} review */
export const selectedTrack = (review) => (review?.selected ? shownTrack(review, review.selected) : null);

/**
 * Whether the engine's boxes of the cursor's frame are still loading: a track without a box may have one there.
 * @param {Pick<ReviewState, 'frame'|'overlays'|'run'>} review
 */
export const areBoxesLoading = ({ frame, overlays, run }) => covers(run, frame) && overlays[frame] === undefined;

/** The fused class of an engine track; null: none. @param {ReviewState} review @param {number} track @returns {number|null} */
export const engineClass = (review, track) => classesOf(review).get(track) ?? null;

/** The engine's name for a track's class, if the set has no label for it. @param {ReviewState} review @param {number} track @returns {string|null} */
function engineWord({ tracks }, track) {
  return tracks?.word?.[tracks.id.indexOf(track)] ?? null;
}

/** @type {WeakMap<object, Map<number, number|null>>} */
const classCache = new WeakMap();

/** Fused class of each engine track. @param {ReviewState} review @returns {Map<number, number|null>} */
function classesOf(review) {
  if (review.tracks === null) return new Map();
  let classes = classCache.get(review.tracks);
  if (!classes) {
    const { id, class_id } = review.tracks;
    classes = new Map(id.map((track, at) => [track, class_id[at]]));
    classCache.set(review.tracks, classes);
  }
  return classes;
}

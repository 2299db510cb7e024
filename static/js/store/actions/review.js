// @ts-check
/**
 * Actions on the review of one run. Pure; without a review they change nothing.
 *
 * @typedef {import('../../state-types.js').State} State
 * @typedef {import('../../state-types.js').ReviewState} ReviewState
 * @typedef {import('../../types.js').Box} Box
 */
import { withAnswer, withCut } from '../../model/following.js';
import { engineTracksOf } from '../../model/track_lane.js';
import { modeChange, modeOf } from '../../modes/index.js';
import { initialReview } from '../initial.js';

/** Number of frames around the cursor whose overlays are kept. */
const KEPT_OVERLAY_FRAMES = 1536;
/** Maximum number of track lanes that are kept. */
const MAX_LANES = 40;

/**
 * @param {State} state
 * @param {Partial<ReviewState>|((review: ReviewState) => Partial<ReviewState>)} change
 * @returns {State}
 */
export function changeReview(state, change) {
  if (state.review === null) return state;
  const fields = typeof change === 'function' ? change(state.review) : change;
  const same = Object.entries(fields).every(([name, value]) => Reflect.get(/** @type {ReviewState} */ (state.review), name) === value);
  return same ? state : { ...state, review: { ...state.review, ...fields } };
}

/** @param {State} state @param {import('../../types.js').Video} video @returns {State} */
export const openReview = (state, video) => ({ ...state, review: initialReview(video, state.layers, state.fewLabels) });

/** @param {State} state @returns {State} */
export const closeReview = (state) => (state.review === null ? state : { ...state, review: null });

/** @param {State} state @param {number} frame @returns {State} */
export const seek = (state, frame) => changeReview(state, (review) => ({ frame: clampFrame(review, frame) }));

/** @param {State} state @param {number} by @returns {State} */
export const step = (state, by) => changeReview(state, (review) => ({ frame: clampFrame(review, review.frame + by), playing: false }));

/** @param {State} state @param {boolean} playing @returns {State} */
export const setPlaying = (state, playing) => changeReview(state, { playing });

/** Play, from the start if the end is reached; or pause. @param {State} state @returns {State} */
export function playOrPause(state) {
  const { review } = state;
  if (review === null || review.playing) return setPlaying(state, false);
  return setPlaying(review.frame >= frameCount(review) - 1 ? seek(state, 0) : state, true);
}

/** Note the ordinal of the picture on screen. @param {State} state @param {number|null} shown @returns {State} */
export const setShown = (state, shown) => changeReview(state, { shown });

/** @param {State} state @param {string|null} key @returns {State} */
export const select = (state, key) => changeReview(state, { selected: key, truthSign: null });

/** Select a sign of the ground truth instead of a track. @param {State} state @param {number} sign @returns {State} */
export const selectTruth = (state, sign) => changeReview(state, { selected: null, truthSign: sign });

/** Set the range of frames of the lanes. @param {State} state @param {{first: number, last: number}} span @returns {State} */
export const showSpan = (state, span) =>
  changeReview(state, (review) => (review.span.first === span.first && review.span.last === span.last ? {} : { span }));

/** @param {State} state @param {number|null} tau   null: the run's @returns {State} */
export const dragTau = (state, tau) => changeReview(state, { tau });

/** @param {State} state @param {Partial<import('../../state-types.js').QueueFilter>} change @returns {State} */
export const changeFilter = (state, change) => changeReview(state, (review) => ({ filter: { ...review.filter, ...change } }));

/** Show or hide a layer, here and in reviews opened later. @param {State} state @param {import('../../state-types.js').LayerName} name @returns {State} */
export function toggleLayer(state, name) {
  const next = changeReview(state, (review) => ({ layers: { ...review.layers, [name]: !review.layers[name] } }));
  return next.review === null ? next : { ...next, layers: { ...next.layers, [name]: next.review.layers[name] } };
}

/** Name all tracks in the picture, or only the selected one and the one under the pointer, here and in reviews opened later. @param {State} state @returns {State} */
export function toggleFewLabels(state) {
  const next = changeReview(state, (review) => ({ fewLabels: !review.fewLabels, hovered: null }));
  return next.review === null ? next : { ...next, fewLabels: next.review.fewLabels };
}

/** Note the track under the pointer. Without effect while all tracks are named. @param {State} state @param {string|null} key @returns {State} */
export const hover = (state, key) => changeReview(state, (review) => (review.fewLabels ? { hovered: key } : {}));

/** @param {State} state @param {ReviewState['mode']} mode @returns {State} */
export const setMode = (state, mode) => changeReview(state, (review) => modeChange(review, mode));

/** Show a view beside the picture; the same again hides it. @param {State} state @param {'recording'|'scene3d'} beside @returns {State} */
export const toggleBeside = (state, beside) => changeReview(state, (review) => ({ beside: review.beside === beside ? null : beside }));

/** Handle a click on a track: the mode's own effect, else select it. @param {State} state @param {string} key @returns {State} */
export const pick = (state, key) => (state.review && modeOf(state.review).onTrackClick ? applyTrackClick(state, key) : select(state, key));

/** Apply the mode's effect of a click on a track, if it has one. @param {State} state @param {string} key @returns {State} */
export const applyTrackClick = (state, key) => changeReview(state, (review) => modeOf(review).onTrackClick?.(review, key) ?? {});

/** @param {State} state @param {{box: Box, key: string}|null} drag @returns {State} */
export const setDrag = (state, drag) => changeReview(state, { drag });

/**
 * Ask for the class of a drawn box. Until it has one, it exists only in the dialog, so that closing the dialog in any
 * way leaves nothing behind and nothing to undo.
 * @param {State} state
 * @param {import('../../state-types.js').Draft} draft
 * @returns {State}
 */
export const askForClass = (state, draft) => ({ ...setMode(state, 'select'), dialog: { kind: 'relabel', data: { draft } } });

/** The box that waits for its class. @param {State} state @returns {import('../../state-types.js').Draft|null} */
export const draftOf = (state) => (state.dialog?.kind === 'relabel' ? (state.dialog.data?.draft ?? null) : null);

/** @param {State} state @param {ReviewState['viewport']} viewport @returns {State} */
export const setViewport = (state, viewport) => changeReview(state, { viewport });

/**
 * Add overlays, and evict those far from the cursor.
 * @param {State} state
 * @param {'overlays'|'secondOverlays'} slot
 * @param {import('../../types.js').Overlay[]} overlays
 * @returns {State}
 */
export function putOverlays(state, slot, overlays) {
  return changeReview(state, (review) => {
    const all = { ...review[slot] };
    for (const overlay of overlays) all[overlay.frame] = overlay;
    const frames = Object.keys(all).map(Number);
    if (frames.length > 2 * KEPT_OVERLAY_FRAMES) {
      for (const frame of frames) if (Math.abs(frame - review.frame) > KEPT_OVERLAY_FRAMES) delete all[frame];
    }
    return { [slot]: all };
  });
}

/**
 * @param {State} state
 * @param {import('../../types.js').GroundTruthBox[]} boxes
 * @param {number} first
 * @param {number} last
 * @returns {State}
 */
export function putTruth(state, boxes, first, last) {
  return changeReview(state, (review) => {
    const truth = { ...review.truth };
    for (let frame = first; frame <= last; frame++) truth[frame] = [];
    for (const { frame, box, class_id, track } of boxes) truth[frame] = [...(truth[frame] ?? []), { box, class_id, track }];
    return { truth };
  });
}

/** The loaded lanes of the selected track. @param {ReviewState} review @returns {ReviewState['laneOf']} */
export function selectedLanes(review) {
  const tracks = review.selected === null ? [] : engineTracksOf(review.selected, review.docs[review.selected]);
  return Object.fromEntries(tracks.filter((track) => review.laneOf[track]).map((track) => [track, review.laneOf[track]]));
}

/** Add a lane. Evicts lanes of other tracks, never those of the selected one. @param {State} state @param {import('../../types.js').TrackLane} lane @returns {State} */
export function putLane(state, lane) {
  return changeReview(state, (review) => {
    const full = Object.keys(review.laneOf).length >= MAX_LANES;
    return { laneOf: { ...(full ? selectedLanes(review) : review.laneOf), [lane.id]: lane } };
  });
}

/** @param {State} state @param {ReviewState['following']} following   null: nothing is followed @returns {State} */
export const setFollowing = (state, following) => changeReview(state, { following });

/**
 * Add the server's answer to a follow. Ignores answers about one that was dropped or replaced.
 * @param {State} state
 * @param {string|null} id   id of the follow in the request
 * @param {import('../../types.js').Follow} answer
 * @returns {State}
 */
export const putFollowing = (state, id, answer) =>
  changeReview(state, ({ following }) => (following !== null && following.id === id ? { following: withAnswer(following, answer) } : {}));

/** Cut off the proposals before or after the cursor. @param {State} state @param {'from'|'to'} end @returns {State} */
export const cutFollowing = (state, end) =>
  changeReview(state, ({ following, frame }) => (following === null ? {} : { following: withCut(following, end, frame) }));

/** Number of frames of the video on the review screen, at least 1. @param {ReviewState|null} review */
export const frameCount = (review) => Math.max(1, review?.timebase?.frames ?? review?.video.frames ?? 1);

/** @param {ReviewState} review @param {number} frame */
const clampFrame = (review, frame) => Math.min(frameCount(review) - 1, Math.max(0, Math.round(frame)));

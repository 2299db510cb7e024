// @ts-check
/**
 * Actions on the review of one run. Pure; outside the review screen they change nothing.
 *
 * @typedef {import('../../state-types.js').State} State
 * @typedef {import('../../state-types.js').ReviewState} ReviewState
 * @typedef {import('../../types.js').Box} Box
 */
import { withAnswer, withCut } from '../../model/following.js';
import { tracksBehind } from '../../model/track_lane.js';
import { changed, modeOf } from '../../modes/index.js';
import { initialReview } from '../initial.js';

/** Frames around the cursor whose overlays are kept. */
const KEPT = 1536;
/** Lanes of tracks that are kept. */
const MOST_LANES = 40;

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

/** Play, from the beginning once the end is reached; or stop. @param {State} state @returns {State} */
export function playOrPause(state) {
  const { review } = state;
  if (review === null || review.playing) return setPlaying(state, false);
  return setPlaying(review.frame >= framesOf(review) - 1 ? seek(state, 0) : state, true);
}

/** The picture of this ordinal is on screen. @param {State} state @param {number|null} shown @returns {State} */
export const setShown = (state, shown) => changeReview(state, { shown });

/** @param {State} state @param {string|null} key @returns {State} */
export const select = (state, key) => changeReview(state, { selected: key, truthSign: null });

/** A sign of the ground truth is chosen in place of a track. @param {State} state @param {number} sign @returns {State} */
export const selectTruth = (state, sign) => changeReview(state, { selected: null, truthSign: sign });

/** What the lanes show. @param {State} state @param {{first: number, last: number}} span @returns {State} */
export const showSpan = (state, span) =>
  changeReview(state, (review) => (review.span.first === span.first && review.span.last === span.last ? {} : { span }));

/** @param {State} state @param {number|null} tau   null: the run's @returns {State} */
export const dragTau = (state, tau) => changeReview(state, { tau });

/** @param {State} state @param {Partial<import('../../state-types.js').QueueFilter>} change @returns {State} */
export const changeFilter = (state, change) => changeReview(state, (review) => ({ filter: { ...review.filter, ...change } }));

/** Show a layer or hide it, here and in whatever is opened next. @param {State} state @param {import('../../state-types.js').LayerName} name @returns {State} */
export function toggleLayer(state, name) {
  const next = changeReview(state, (review) => ({ layers: { ...review.layers, [name]: !review.layers[name] } }));
  return next.review === null ? next : { ...next, layers: { ...next.layers, [name]: next.review.layers[name] } };
}

/** Name all tracks in the picture, or only the selected one and the one under the pointer, here and in whatever is opened next. @param {State} state @returns {State} */
export function toggleFewLabels(state) {
  const next = changeReview(state, (review) => ({ fewLabels: !review.fewLabels, hovered: null }));
  return next.review === null ? next : { ...next, fewLabels: next.review.fewLabels };
}

/** The pointer is over a track; where all are named nobody asks. @param {State} state @param {string|null} key @returns {State} */
export const hover = (state, key) => changeReview(state, (review) => (review.fewLabels ? { hovered: key } : {}));

/** @param {State} state @param {ReviewState['mode']} mode @returns {State} */
export const setMode = (state, mode) => changeReview(state, (review) => changed(review, mode));

/** What stands beside the picture; the same again: nothing. @param {State} state @param {'recording'|'scene3d'} beside @returns {State} */
export const toggleBeside = (state, beside) => changeReview(state, (review) => ({ beside: review.beside === beside ? null : beside }));

/** A click on a track: the mode takes it, else it is selected. @param {State} state @param {string} key @returns {State} */
export const pick = (state, key) => (state.review && modeOf(state.review).take ? take(state, key) : select(state, key));

/** The mode takes a track, where it takes any. @param {State} state @param {string} key @returns {State} */
export const take = (state, key) => changeReview(state, (review) => modeOf(review).take?.(review, key) ?? {});

/** @param {State} state @param {{box: Box, key: string}|null} drag @returns {State} */
export const setDrag = (state, drag) => changeReview(state, { drag });

/**
 * A box was drawn: ask for its class. Until it has one it lives in the dialog alone, so that closing the dialog, in
 * whatever way, leaves nothing behind and nothing to undo.
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
 * Take over overlays; those far from the cursor make room.
 * @param {State} state
 * @param {'overlays'|'secondOverlays'} slot
 * @param {import('../../types.js').Overlay[]} found
 * @returns {State}
 */
export function putOverlays(state, slot, found) {
  return changeReview(state, (review) => {
    const all = { ...review[slot] };
    for (const overlay of found) all[overlay.frame] = overlay;
    const frames = Object.keys(all).map(Number);
    if (frames.length > 2 * KEPT) {
      for (const frame of frames) if (Math.abs(frame - review.frame) > KEPT) delete all[frame];
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

/** The lanes that the selected track shows, as far as they are there. @param {ReviewState} review @returns {ReviewState['laneOf']} */
export function selectedLanes(review) {
  const tracks = review.selected === null ? [] : tracksBehind(review.selected, review.docs[review.selected]);
  return Object.fromEntries(tracks.filter((track) => review.laneOf[track]).map((track) => [track, review.laneOf[track]]));
}

/** Those of other tracks make room, never those of the selected one. @param {State} state @param {import('../../types.js').TrackLane} lane @returns {State} */
export function putLane(state, lane) {
  return changeReview(state, (review) => {
    const full = Object.keys(review.laneOf).length >= MOST_LANES;
    return { laneOf: { ...(full ? selectedLanes(review) : review.laneOf), [lane.id]: lane } };
  });
}

/** @param {State} state @param {ReviewState['following']} following   null: nothing is followed @returns {State} */
export const setFollowing = (state, following) => changeReview(state, { following });

/**
 * What the server answered; one that was dropped or replaced meanwhile is not heard.
 * @param {State} state
 * @param {string|null} id   of the follow that was asked about
 * @param {import('../../types.js').Follow} answer
 * @returns {State}
 */
export const putFollowing = (state, id, answer) =>
  changeReview(state, ({ following }) => (following !== null && following.id === id ? { following: withAnswer(following, answer) } : {}));

/** Cut off what is proposed before or behind the cursor. @param {State} state @param {'from'|'to'} side @returns {State} */
export const cutFollowing = (state, side) =>
  changeReview(state, ({ following, frame }) => (following === null ? {} : { following: withCut(following, side, frame) }));

/** Frames of the video on the review screen, at least 1. @param {ReviewState|null} review */
export const framesOf = (review) => Math.max(1, review?.timebase?.frames ?? review?.video.frames ?? 1);

/**
 * @param {ReviewState} review
 * @param {number} frame
 */
const clampFrame = (review, frame) => Math.min(framesOf(review) - 1, Math.max(0, Math.round(frame)));

// @ts-check
/**
 * Shows the picture at the cursor, and moves the cursor while the video plays.
 *
 * Playback follows the presentation times of the frame table. A frame is shown when its picture and its overlays are
 * loaded. If they come too late, the video plays slower.
 *
 * @typedef {import('../state-types.js').Store} Store
 * @typedef {import('./cache.js').FrameCache} FrameCache
 * @typedef {import('./cache.js').Shot} Shot
 *
 * Paints a picture. `passing`: shown only briefly while the user scrubs, so not worth ten milliseconds of smoothing.
 * @typedef {(shot: Shot, passing: boolean) => void} Paint
 */
import { ApiError, mayRepeat, sentence } from '../api/errors.js';
import { hideBanner, showBanner } from '../store/actions/page.js';
import { setPlaying, setShown, seek } from '../store/actions/review.js';

/** Number of pictures loaded ahead of the cursor, or behind it after a step back. */
const AHEAD = 24;
const BEHIND = 8;
/** Steps of more frames than this are jumps; two frames are a key press that was drawn late. */
const NEAR = 2;
/** Pause after a jump before the sharp picture and its neighbours are loaded, ms. */
const REST = 180;
/** The longest wait for a picture that the scrubbing user has already left, ms. */
const PATIENCE = 400;
/** Pause before a picture is requested again after the server was unreachable or late, ms. */
const AGAIN = 1000;
/** The largest delay of playback before its clock is set back, s. */
const SLACK = 0.12;

/**
 * @typedef {object} Player
 * @property {() => void} sync          follow a change of the state
 * @property {(paint: Paint) => void} onShot   sets the function that paints a picture
 * @property {(width: number) => void} setWidth
 * @property {(speed: number) => void} setSpeed
 * @property {() => number} speed
 * @property {() => {frames: number, late: number}} tally      since playing began
 * @property {() => void} destroy
 */

/**
 * @param {Store} store
 * @param {FrameCache} cache
 * @param {{now?: () => number, tick?: (run: () => void) => number, untick?: (handle: number) => void, again?: number}} [clock]   again: pause before a picture is requested again, ms
 * @returns {Player}
 */
export function createPlayer(
  store,
  cache,
  { now = () => performance.now(), tick = requestAnimationFrame, untick = cancelAnimationFrame, again = AGAIN } = {},
) {
  /** @type {Paint} */
  let paint = () => {};
  let wanted = -1;
  /** The frame around which pictures were loaded last; -1: none yet. */
  let before = -1;
  let speed = 1;
  let ended = false;
  let handle = 0;
  /** Presentation time and clock when playing began. @type {{media: number, clock: number}|null} */
  let started = null;
  let tally = { frames: 0, late: 0 };
  /** Number of times in a row that playback has waited for the same frame. */
  let stalled = 0;

  /** @type {ReturnType<typeof setTimeout>|undefined} */
  let resting;
  /** The jump whose picture is being loaded, and its start time. @type {{frame: number, since: number}|null} */
  let leap = null;

  /** @param {number} frame */
  function loadAround(frame) {
    const last = (store.get().review?.timebase?.frames ?? 1) - 1;
    const back = before >= 0 && frame < before;
    const frames = [];
    for (let k = 1; k <= (back ? BEHIND : AHEAD); k++) frames.push(back ? frame - k : frame + k);
    if (!back) frames.push(frame - 1, frame - 2);
    cache.want(frames.filter((k) => k >= 0 && k <= last));
    before = frame;
  }

  /** @param {number} frame */
  const isNear = (frame) => Math.abs(frame - before) <= NEAR || Boolean(store.get().review?.playing);

  /** @param {number} frame */
  function bring(frame) {
    wanted = frame;
    clearTimeout(resting);
    const ready = cache.peek(frame);
    const near = isNear(frame);
    if (ready) put(ready, !near);
    if (near) {
      void show(frame, cache.load(frame));
      loadAround(frame);
      return;
    }
    resting = setTimeout(() => arrive(frame), REST);
    if (leap === null || now() - leap.since > PATIENCE) void preview(frame);
  }

  /** Load the sharp picture, because the cursor rests. @param {number} frame */
  function arrive(frame) {
    if (leap?.frame === frame && now() - leap.since < PATIENCE) {
      resting = setTimeout(() => arrive(frame), REST / 4); // the requested picture is about to arrive
      return;
    }
    void show(frame, cache.load(frame));
    loadAround(frame);
  }

  /**
   * A scrubbing user wants the next place soon rather than sharp, and not its neighbours. Loads one picture at a time
   * and shows it even if the cursor has moved on: if each move cancelled the load, no picture would arrive before the
   * cursor rests.
   * @param {number} frame
   */
  async function preview(frame) {
    const mine = { frame, since: now() };
    leap = mine;
    const request = cache.preview(frame);
    cache.want([]);
    await show(frame, request, () => leap === mine && store.get().review?.shown !== wanted, true);
    if (leap !== mine || ended) return;
    leap = null;
    if (wanted !== frame && !isNear(wanted) && !cache.peek(wanted)) void preview(wanted);
  }

  /**
   * @param {number} frame
   * @param {Promise<Shot>} request
   * @param {() => boolean} [anyway]   whether the picture is shown although the cursor has left it
   * @param {boolean} [passing]
   */
  async function show(frame, request, anyway = () => false, passing = false) {
    try {
      const shot = await request;
      if (!ended && (wanted === frame || anyway())) {
        put(shot, passing);
        store.dispatch(hideBanner, 'picture');
      }
    } catch (thrown) {
      if (wanted !== frame || dropped(thrown)) return;
      fail(frame, thrown, () => arrive(frame));
    }
  }

  /** Load the frame that playback waits for. If it fails, its banner stays until it is there or the cursor has moved. @param {number} frame */
  async function bringNext(frame) {
    try {
      await cache.load(frame);
      if (wanted === frame - 1) store.dispatch(hideBanner, 'picture');
    } catch (thrown) {
      if (wanted !== frame - 1 || dropped(thrown)) return;
      fail(frame, thrown, () => void bringNext(frame));
    }
  }

  /** Say that a frame failed, and request it again if that may help, so that it returns without a move of the cursor. @param {number} frame @param {unknown} thrown @param {() => void} load */
  function fail(frame, thrown, load) {
    if (ended) return;
    store.dispatch((state) =>
      showBanner(setPlaying(state, false), { id: 'picture', tone: 'error', text: `Frame ${frame} cannot be shown. ${sentence(thrown)}` }),
    );
    if (!mayRepeat(thrown)) return;
    clearTimeout(resting);
    resting = setTimeout(load, again);
  }

  /** @param {Shot} shot @param {boolean} passing */
  function put(shot, passing) {
    store.dispatch(setShown, shot.frame);
    paint(shot, passing); // after the change of the state, so that picture and layers appear together
  }

  function beat() {
    handle = 0;
    const review = store.get().review;
    if (ended || !review?.playing || !review.timebase) {
      started = null;
      return;
    }
    const { timebase } = review;
    started ??= { media: timebase.secondsAt(review.frame), clock: now() };
    const due = started.media + ((now() - started.clock) / 1000) * speed;
    let target = Math.max(review.frame, timebase.frameAt(due));
    while (target > review.frame && !(cache.peek(target) && (review.overlays[target] || !covered(review, target)))) target--;
    if (target > review.frame) {
      stalled = 0;
      tally = { frames: tally.frames + 1, late: tally.late + (timebase.frameAt(due) > target ? 1 : 0) };
      store.dispatch(seek, target);
    }
    if (due - timebase.secondsAt(target) > SLACK + 1 / 25) {
      // too slow: continue from here instead of skipping frames
      started = { media: timebase.secondsAt(target), clock: now() };
      // a failed prefetch is not repeated: request the frame itself, so that its error is shown
      if (target === review.frame && ++stalled === 10) void bringNext(target + 1);
    }
    if (target >= timebase.frames - 1) store.dispatch(setPlaying, false);
    handle = tick(beat);
  }

  return {
    sync() {
      const review = store.get().review;
      if (!review?.timebase || ended) return;
      if (review.frame !== wanted) bring(review.frame);
      if (review.playing && !handle) {
        tally = { frames: 0, late: 0 };
        started = null;
        handle = tick(beat);
      }
    },
    onShot(how) {
      paint = how;
    },
    setWidth(width) {
      cache.setWidth(width);
      const shot = wanted >= 0 ? cache.peek(wanted) : null;
      if (wanted >= 0 && (!shot || shot.width < width)) bring(wanted);
    },
    setSpeed(value) {
      speed = value;
      started = null;
    },
    speed: () => speed,
    tally: () => tally,
    destroy() {
      ended = true;
      clearTimeout(resting);
      if (handle) untick(handle);
      cache.clear();
    },
  };
}

/** Whether the run's results cover a frame. @param {import('../state-types.js').ReviewState} review @param {number} frame */
function covered({ run }, frame) {
  return run !== null && run.first <= frame && frame < run.first + run.frames_done;
}

/** @param {unknown} thrown @returns {boolean} whether the load was cancelled */
function dropped(thrown) {
  return (thrown instanceof ApiError && thrown.code === 'aborted') || (thrown instanceof Error && thrown.name === 'AbortError');
}

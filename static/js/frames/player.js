// @ts-check
/**
 * Brings the picture of the cursor on screen, and moves the cursor while the video plays.
 *
 * Playing follows the presentation times of the frame table. A frame is shown once its picture and its overlays are
 * there; if they come too late the video plays slower.
 *
 * @typedef {import('../state-types.js').Store} Store
 * @typedef {import('./cache.js').FrameCache} FrameCache
 * @typedef {import('./cache.js').Shot} Shot
 *
 * Puts a picture on screen. One that passes, while somebody scrubs, is not worth ten milliseconds of smoothing.
 * @typedef {(shot: Shot, passing: boolean) => void} Paint
 */
import { ApiError, sentence } from '../api/errors.js';
import { hideBanner, showBanner } from '../store/actions/page.js';
import { setPlaying, setShown, seek } from '../store/actions/review.js';

/** Pictures loaded ahead of the cursor, and behind it when it was stepped back. */
const AHEAD = 24;
const BEHIND = 8;
/** A step of more frames is a leap; two are one key press that was drawn late. */
const NEAR = 2;
/** How long the cursor rests after a leap before the sharp picture and its neighbours are loaded, ms. */
const REST = 180;
/** After this a picture that somebody who scrubs has left is no longer waited for, ms. */
const PATIENCE = 400;
/** A picture that did not come because the server was away is asked for again after this, ms. */
const AGAIN = 1000;
/** How far behind time playing may fall before its clock is set back, s. */
const SLACK = 0.12;

/**
 * @typedef {object} Player
 * @property {() => void} sync          the state has changed
 * @property {(paint: Paint) => void} onShot   how a picture comes on screen
 * @property {(width: number) => void} setWidth
 * @property {(speed: number) => void} setSpeed
 * @property {() => number} speed
 * @property {() => {frames: number, late: number}} tally      of the present playing
 * @property {() => void} destroy
 */

/**
 * @param {Store} store
 * @param {FrameCache} cache
 * @param {{now?: () => number, tick?: (run: () => void) => number, untick?: (handle: number) => void, again?: number}} [clock]   again: pause before a picture is asked for once more, ms
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
  /** Where pictures were loaded around last; -1: nowhere yet. */
  let before = -1;
  let speed = 1;
  let ended = false;
  let handle = 0;
  /** Presentation time and clock when playing began. @type {{media: number, clock: number}|null} */
  let started = null;
  let tally = { frames: 0, late: 0 };
  /** How often in a row playing waited for the same frame. */
  let stalled = 0;

  /** @type {ReturnType<typeof setTimeout>|undefined} */
  let resting;
  /** The leap whose picture is on its way, and since when. @type {{frame: number, since: number}|null} */
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

  /** The cursor rests. @param {number} frame */
  function arrive(frame) {
    if (leap?.frame === frame && now() - leap.since < PATIENCE) {
      resting = setTimeout(() => arrive(frame), REST / 4); // what was asked for is about to come
      return;
    }
    void show(frame, cache.load(frame));
    loadAround(frame);
  }

  /**
   * Whoever scrubs wants the next place, not this one's neighbours, and soon rather than sharp. One picture at a time,
   * shown even when the cursor has gone on: given up at every move, none would come before the cursor rests.
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
   * @param {() => boolean} [anyway]   whether the picture is shown though the cursor has left it
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
      fail(frame, thrown);
      if (!ended && thrown instanceof ApiError && thrown.code === 'offline') {
        clearTimeout(resting);
        resting = setTimeout(() => arrive(frame), again); // nobody moves the cursor to see what has come back
      }
    }
  }

  /** @param {number} frame @param {unknown} thrown */
  function fail(frame, thrown) {
    if (ended) return;
    store.dispatch((state) =>
      showBanner(setPlaying(state, false), { id: 'picture', tone: 'error', text: `Frame ${frame} cannot be shown. ${sentence(thrown)}` }),
    );
  }

  /** @param {Shot} shot @param {boolean} passing */
  function put(shot, passing) {
    store.dispatch(setShown, shot.frame);
    paint(shot, passing); // picture and layers together, hence after the state knows
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
      // too slow: go on from here rather than leap
      started = { media: timebase.secondsAt(target), clock: now() };
      // a prefetch that failed is not repeated: ask by name, and hear why
      if (target === review.frame && ++stalled === 10) {
        cache.load(target + 1).catch((thrown) => dropped(thrown) || fail(target + 1, thrown));
      }
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

/** Whether the run has results for a frame. @param {import('../state-types.js').ReviewState} review @param {number} frame */
function covered({ run }, frame) {
  return run !== null && run.first <= frame && frame < run.first + run.frames_done;
}

/** @param {unknown} thrown @returns {boolean} nobody wants the picture any more */
function dropped(thrown) {
  return (thrown instanceof ApiError && thrown.code === 'aborted') || (thrown instanceof Error && thrown.name === 'AbortError');
}

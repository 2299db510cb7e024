// @ts-check
/**
 * Shows the picture at the cursor, and moves the cursor while the video plays.
 *
 * Playback follows the presentation times of the frame table. A frame is shown when its picture and its overlays are
 * loaded. If they come too late, the video plays slower.
 *
 * @typedef {import('../state-types.js').Store} Store
 * @typedef {import('./cache.js').FrameCache} FrameCache
 * @typedef {import('./cache.js').Picture} Picture
 *
 * Paints a picture. `isBrief`: shown only briefly while the user scrubs, so not worth ten milliseconds of smoothing.
 * @typedef {(picture: Picture, isBrief: boolean) => void} Paint
 */
import { ApiError, isRetryable, errorMessage } from '../api/errors.js';
import { covers } from '../model/run_progress.js';
import { hideBanner, showBanner } from '../store/actions/page.js';
import { setPlaying, setShown, seek } from '../store/actions/review.js';

/** Number of pictures loaded ahead of the cursor, or behind it after a step back. */
const PREFETCH_AHEAD = 24;
const PREFETCH_BEHIND = 8;
/** Steps of more frames than this are jumps; two frames are a key press that was drawn late. */
const MAX_STEP_FRAMES = 2;
/** Time on a frame after a jump before its sharp picture and its neighbours are loaded, ms. */
const SCRUB_PAUSE_MS = 180;
/** The longest wait for a picture that the scrubbing user has already left, ms. */
const MAX_PREVIEW_WAIT_MS = 400;
/** Delay before a failed picture is requested again, ms. */
const RETRY_DELAY_MS = 1000;
/** The longest time that a frame may be overdue before the clock of playback is set back, s. */
const MAX_LAG_S = 0.12;

/**
 * @typedef {object} Player
 * @property {() => void} sync          follow a change of the state
 * @property {(paint: Paint) => void} setPainter   sets the function that paints a picture
 * @property {(width: number) => void} setWidth
 * @property {(speed: number) => void} setSpeed
 * @property {() => {frames: number, late: number}} tally      since playing began
 * @property {() => void} destroy
 */

/**
 * @param {Store} store
 * @param {FrameCache} cache
 * @param {{now?: () => number, tick?: (run: () => void) => number, cancelTick?: (handle: number) => void, retryDelayMs?: number}} [clock]   retryDelayMs: delay before a failed picture is requested again
 * @returns {Player}
 */
export function createPlayer(
  store,
  cache,
  { now = () => performance.now(), tick = requestAnimationFrame, cancelTick = cancelAnimationFrame, retryDelayMs = RETRY_DELAY_MS } = {},
) {
  /** @type {Paint} */
  let paint = () => {};
  let target = -1;
  /** The frame around which pictures were loaded last; -1: none yet. */
  let loadedAround = -1;
  let speed = 1;
  let ended = false;
  let handle = 0;
  /** Presentation time and clock when playing began. @type {{media: number, clock: number}|null} */
  let started = null;
  let tally = { frames: 0, late: 0 };
  /** Number of times in a row that playback has waited for the same frame. */
  let stalled = 0;
  /** The frame at which playback has left the cursor. */
  let playedFrame = -1;

  /** @type {ReturnType<typeof setTimeout>|undefined} */
  let timer;
  /** The jump whose picture is being loaded, and its start time. @type {{frame: number, since: number}|null} */
  let pendingPreview = null;

  /** @param {number} frame */
  function loadAround(frame) {
    const last = (store.get().review?.timebase?.frames ?? 1) - 1;
    const isBackward = loadedAround >= 0 && frame < loadedAround;
    const frames = [];
    for (let k = 1; k <= (isBackward ? PREFETCH_BEHIND : PREFETCH_AHEAD); k++) frames.push(isBackward ? frame - k : frame + k);
    if (!isBackward) frames.push(frame - 1, frame - 2);
    cache.prefetch(frames.filter((k) => k >= 0 && k <= last));
    loadedAround = frame;
  }

  /** @param {number} frame */
  const isNear = (frame) => Math.abs(frame - loadedAround) <= MAX_STEP_FRAMES || Boolean(store.get().review?.playing);

  /** @param {number} frame */
  function showFrame(frame) {
    target = frame;
    clearTimeout(timer);
    const ready = cache.peek(frame);
    const near = isNear(frame);
    if (ready) paintPicture(ready, !near);
    if (near) {
      void show(frame, cache.load(frame));
      loadAround(frame);
      return;
    }
    timer = setTimeout(() => loadSharp(frame), SCRUB_PAUSE_MS);
    if (pendingPreview === null || now() - pendingPreview.since > MAX_PREVIEW_WAIT_MS) void preview(frame);
  }

  /** Load the sharp picture, because the cursor rests. @param {number} frame */
  function loadSharp(frame) {
    if (pendingPreview?.frame === frame && now() - pendingPreview.since < MAX_PREVIEW_WAIT_MS) {
      timer = setTimeout(() => loadSharp(frame), SCRUB_PAUSE_MS / 4); // the requested picture is about to arrive
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
    const current = { frame, since: now() };
    pendingPreview = current;
    const request = cache.preview(frame);
    cache.prefetch([]);
    await show(frame, request, () => pendingPreview === current && store.get().review?.shown !== target, true);
    if (pendingPreview !== current || ended) return;
    pendingPreview = null;
    if (target !== frame && !isNear(target) && !cache.peek(target)) void preview(target);
  }

  /**
   * @param {number} frame
   * @param {Promise<Picture>} request
   * @param {() => boolean} [isStillWanted]   whether the picture is shown although the cursor has left it
   * @param {boolean} [isBrief]
   */
  async function show(frame, request, isStillWanted = () => false, isBrief = false) {
    try {
      const picture = await request;
      if (!ended && (target === frame || isStillWanted())) {
        paintPicture(picture, isBrief);
        store.dispatch(hideBanner, 'picture');
      }
    } catch (thrown) {
      if (target !== frame || wasCancelled(thrown)) return;
      fail(frame, thrown, () => loadSharp(frame));
    }
  }

  /** Load the frame that playback waits for. If it fails, its banner stays until it is there or the cursor has moved. @param {number} frame */
  async function loadNext(frame) {
    try {
      await cache.load(frame);
      if (target === frame - 1) store.dispatch(hideBanner, 'picture');
    } catch (thrown) {
      if (target !== frame - 1 || wasCancelled(thrown)) return;
      fail(frame, thrown, () => void loadNext(frame));
    }
  }

  /** Say that a frame failed, and request it again if that may help, so that it returns without a move of the cursor. @param {number} frame @param {unknown} thrown @param {() => void} load */
  function fail(frame, thrown, load) {
    if (ended) return;
    store.dispatch((state) =>
      showBanner(setPlaying(state, false), {
        id: 'picture',
        tone: 'error',
        text: `Frame ${frame} cannot be shown. ${errorMessage(thrown)}`,
      }),
    );
    if (!isRetryable(thrown)) return;
    clearTimeout(timer);
    timer = setTimeout(load, retryDelayMs);
  }

  /** @param {Picture} picture @param {boolean} isBrief */
  function paintPicture(picture, isBrief) {
    store.dispatch(setShown, picture.frame);
    paint(picture, isBrief); // after the change of the state, so that picture and layers appear together
  }

  function onTick() {
    handle = 0;
    const review = store.get().review;
    if (ended || !review?.playing || !review.timebase) {
      started = null;
      return;
    }
    const { timebase } = review;
    if (review.frame !== playedFrame) [started, stalled] = [null, 0]; // the user has moved the cursor: play on from there
    started ??= { media: timebase.secondsAt(review.frame), clock: now() };
    const mediaTime = started.media + ((now() - started.clock) / 1000) * speed;
    let nextFrame = Math.max(review.frame, timebase.frameAt(mediaTime));
    while (nextFrame > review.frame && !(cache.peek(nextFrame) && (review.overlays[nextFrame] || !covers(review.run, nextFrame))))
      nextFrame--;
    if (nextFrame > review.frame) {
      stalled = 0;
      tally = { frames: tally.frames + 1, late: tally.late + (timebase.frameAt(mediaTime) > nextFrame ? 1 : 0) };
      store.dispatch(seek, nextFrame);
    }
    playedFrame = nextFrame;
    if (mediaTime - timebase.secondsAt(nextFrame + 1) > MAX_LAG_S) {
      // too slow: continue from here instead of skipping frames
      started = { media: timebase.secondsAt(nextFrame), clock: now() };
      // a failed prefetch is not repeated: request the frame itself, so that its error is shown
      if (nextFrame === review.frame && ++stalled === 10) void loadNext(nextFrame + 1);
    }
    if (nextFrame >= timebase.frames - 1) store.dispatch(setPlaying, false);
    handle = tick(onTick);
  }

  return {
    sync() {
      const review = store.get().review;
      if (!review?.timebase || ended) return;
      if (review.frame !== target) showFrame(review.frame);
      if (review.playing && !handle) {
        tally = { frames: 0, late: 0 };
        started = null;
        handle = tick(onTick);
      }
    },
    setPainter(how) {
      paint = how;
    },
    setWidth(width) {
      cache.setWidth(width);
      const picture = target >= 0 ? cache.peek(target) : null;
      if (target >= 0 && (!picture || picture.width < width)) showFrame(target);
    },
    setSpeed(value) {
      speed = value;
      started = null;
    },
    tally: () => tally,
    destroy() {
      ended = true;
      clearTimeout(timer);
      if (handle) cancelTick(handle);
      cache.clear();
    },
  };
}

/** @param {unknown} thrown @returns {boolean} whether the load was cancelled */
function wasCancelled(thrown) {
  return (thrown instanceof ApiError && thrown.code === 'aborted') || (thrown instanceof Error && thrown.name === 'AbortError');
}

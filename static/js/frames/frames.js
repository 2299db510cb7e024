// @ts-check
/** The pictures of the video on the screen: a cache and a player that change with it. */

import { createFrameCache } from './cache.js';
import { createPlayer } from './player.js';

/** @param {import('../state-types.js').Store} store @param {import('../api/client.js').Api} api */
export function createFrames(store, api) {
  /** @type {import('./player.js').Player|null} */
  let player = null;
  let video = '';
  /** @type {import('./player.js').Paint} */
  let paint = () => {};
  let width = 1280;
  let speed = 1;

  return {
    /** Follow a change of the state. */
    sync() {
      const { review } = store.get();
      const wanted = review?.timebase ? review.video.id : '';
      if (wanted !== video) {
        player?.destroy();
        video = wanted;
        player = wanted ? createPlayer(store, createFrameCache(api, wanted)) : null;
        player?.setPainter((picture, isBrief) => paint(picture, isBrief));
        player?.setWidth(width);
        player?.setSpeed(speed);
      }
      player?.sync();
    },
    /** Set the function that paints a picture. @param {import('./player.js').Paint} how */
    setPainter(how) {
      paint = how;
    },
    /** Set the width at which pictures are useful, px. @param {number} wanted */
    setWidth(wanted) {
      if (wanted === width) return;
      width = wanted;
      player?.setWidth(wanted);
    },
    /** @param {number} value */
    setSpeed(value) {
      speed = value;
      player?.setSpeed(value);
    },
    /** Number of frames shown, and shown late, since playing began. */
    tally: () => player?.tally() ?? { frames: 0, late: 0 },
  };
}

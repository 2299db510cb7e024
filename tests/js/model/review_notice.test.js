// @ts-check
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { isOpening, reviewNotice } from '../../../static/js/model/review_notice.js';

/** @param {object} more @returns {any} */
const state = (more) => ({
  route: { screen: 'review', video: 'v', run: null },
  videos: [{ id: 'v' }],
  runs: { v: [{ id: 'a' }] },
  review: null,
  ...more,
});
const review = (/** @type {string|null} */ run, timebase = {}) => ({ video: { id: 'v' }, timebase, run: run && { id: run } });
const to = (/** @type {string} */ run) => ({ screen: 'review', video: 'v', run });

/** @type {[string, object, ReturnType<typeof reviewNotice>][]} */
const CASES = [
  ['nothing is known yet', { videos: null }, 'waiting'],
  ['the review is on its way', {}, 'waiting'],
  ['it is there', { review: review('a') }, 'none'],
  ['its run was removed', { review: review('b') }, 'gone'],
  ['its last run was removed', { review: review('b'), runs: { v: [] } }, 'gone'],
  ['its video was removed', { review: review('a'), videos: [] }, 'unknown'],
  ['an address names a run that is not there', { route: to('b'), review: review(null) }, 'gone'],
  ['a video without a run', { review: review(null), runs: { v: [] } }, 'none'],
  ['another run of the video opens', { route: to('b'), review: review('a') }, 'none'],
  ['runs have not come yet', { route: to('b'), review: review('b'), runs: {} }, 'none'],
];
for (const [name, more, kind] of CASES) {
  test(`notice: ${name}`, () => assert.equal(reviewNotice(state(more)), kind));
}

const here = (/** @type {object} */ more) => ({ ...review('a'), tracks: {}, seq: 0, ...more });
/** @type {[string, object, boolean][]} */
const OPENING = [
  ['nothing of it is there', {}, true],
  ['everything is there', { review: here({}) }, false],
  ['the one that is left is on the screen still', { route: { screen: 'review', video: 'w', run: null }, review: here({}) }, true],
  ['another run of the video is on its way', { route: to('b'), review: here({}) }, true],
  ['its frames are not known yet', { review: here({ timebase: null }) }, true],
  ['its tracks have not come', { review: here({ tracks: null }) }, true],
  ['its edits have not come', { review: here({ seq: null }) }, true],
  ['its run has not begun', { review: here({ tracks: null, run: { id: 'a', state: 'queued', frames_done: 0 } }) }, false],
  ['a video without a run', { review: here({ run: null, tracks: null, seq: null }) }, false],
  ['the run that is named has not come', { route: to('a'), review: here({ run: null }) }, true],
];
for (const [name, more, opening] of OPENING) {
  test(`opening: ${name}`, () => assert.equal(isOpening(state(more)), opening));
}

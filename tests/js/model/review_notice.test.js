// @ts-check
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { reviewNotice } from '../../../static/js/model/review_notice.js';

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

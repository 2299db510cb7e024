// @ts-check
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { openVideos, reviewedMessage } from '../../../static/js/model/open_videos.js';

/** @param {string} id @param {number} tracks @param {number} reviewed @param {object} [more] */
const reviewed = (id, tracks, reviewed, more = {}) =>
  /** @type {any} */ ({ id, state: 'ready', missing: false, latest_run: 'r', review: { tracks, reviewed }, ...more });

test('the next video is the next one below that has open tracks, then from the top', () => {
  const videos = [reviewed('a', 5, 2), reviewed('b', 9, 0), reviewed('c', 3, 3), reviewed('d', 8, 4)];
  assert.deepEqual(
    [openVideos(videos, 'b').next?.id, openVideos(videos, 'd').next?.id, openVideos(videos, undefined).next?.id],
    ['d', 'a', 'a'],
  );
  const { videos: count, tracks } = openVideos(videos, 'b');
  assert.deepEqual([count, tracks], [2, 7]);
});

test('videos that cannot be reviewed have no button: no run, no file, a failed or running import', () => {
  const videos = [
    reviewed('a', 5, 2, { latest_run: null }),
    reviewed('b', 5, 2, { missing: true }),
    reviewed('c', 5, 2, { state: 'failed' }),
    reviewed('d', 5, 2, { state: 'importing' }),
    reviewed('e', 2, 3),
  ];
  assert.deepEqual(openVideos(videos, 'x'), { videos: 0, tracks: 0, next: null });
  assert.deepEqual(openVideos(null, 'x'), { videos: 0, tracks: 0, next: null });
});

test('the words count and agree', () => {
  const next = reviewed('a', 1, 0);
  assert.equal(
    reviewedMessage({ videos: 0, tracks: 0, next: null }, 4),
    'All tracks of this video are reviewed. No other video has an open track.',
  );
  assert.equal(
    reviewedMessage({ videos: 0, tracks: 0, next: null }, 0),
    'This video has no track to review. No other video has an open track.',
  );
  assert.equal(
    reviewedMessage({ videos: 1, tracks: 1, next }, 4),
    'All tracks of this video are reviewed. 1 other video has 1 open track.',
  );
  assert.equal(
    reviewedMessage({ videos: 2, tracks: 1200, next }, 0),
    'This video has no track to review. 2 other videos have 1,200 open tracks.',
  );
});

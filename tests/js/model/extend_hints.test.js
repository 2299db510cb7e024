// @ts-check
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { extendHint } from '../../../static/js/model/extend_hints.js';
import { trackEntries } from '../../../static/js/model/track_entries.js';
import { syntheticRun } from '../harness/synthetic_run.js';

const VIDEO = { width: 1000, height: 500, frames: 100 };

/** @param {object} columns */
function hintFor(columns) {
  /** @type {any} */
  const tracks = { ...syntheticRun(100, 1).tracks, id: [1], first: [10], last: [40], first_box: [null], last_box: [null], ...columns };
  return extendHint(tracks, trackEntries(tracks, {})[0], VIDEO);
}

test('the hint names the end at which the sign may be visible further, and its key', () => {
  const inside = [[100, 100, 124, 130]];
  assert.equal(hintFor({ first_box: inside }), 'Begins 24 px wide, perhaps too late: press , to look further back.');
  assert.equal(hintFor({ last_box: inside }), 'Ends inside the picture, perhaps too early: press . to look further on.');
  assert.equal(
    hintFor({ first_box: inside, last_box: inside }),
    'Begins 24 px wide, perhaps too late: press , to look further back. Ends inside the picture, perhaps too early: press . to look further on.',
  );
});

test('nothing is said of small, cut and outermost ends', () => {
  const [inside, cut] = [[[100, 100, 124, 130]], [[100, 100, 998, 130]]];
  assert.equal(hintFor({ first_box: [[100, 100, 119, 130]] }), '', 'it may just have become visible');
  assert.equal(hintFor({ first_box: cut, last_box: cut }), '', 'it enters and leaves the picture');
  assert.equal(hintFor({ first: [0], last: [99], first_box: inside, last_box: inside }), '', 'the video has no further frames');
});

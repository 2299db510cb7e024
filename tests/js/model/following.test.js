// @ts-check
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { blankDoc, emptyDoc } from '../../../static/js/model/documents.js';
import { boxAt } from '../../../static/js/model/effective.js';
import { applyCommand } from '../../../static/js/model/commands.js';
import {
  acceptCommand,
  describeFollowing,
  proposedFrameCount,
  anchorsAround,
  newFollowing,
  proposalAt,
  followRange,
  requestFrom,
  requestWith,
  acceptedSpan,
  thinBoxes,
  withAnswer,
  withCut,
} from '../../../static/js/model/following.js';
import { pluck } from '../pluck.js';
import { keyFrame } from '../server_data.js';

/** @typedef {import('../../../static/js/types.js').Box} Box */
/** @typedef {import('../../../static/js/types.js').Follow} Follow */

/** A box that grows as a sign does that a camera nears. @param {number} frame @returns {Box} */
const at = (frame) => {
  const side = 2000 / (140 - frame);
  return [100 + side, 50, 100 + 2 * side, 50 + side];
};
/** @param {object} [change] */
const key = (change) => keyFrame({ box: at(0), ...change });
/** @param {Partial<Follow>} change @returns {Follow} */
const answer = (change) => ({
  id: 'f1',
  run_id: 'r',
  key: 'h1',
  anchors: [],
  only: null,
  first: 0,
  last: null,
  state: 'running',
  error: null,
  note: '',
  proposals: [],
  endings: [],
  next: 1,
  ...change,
});
/** @param {number} frame @param {number} [confidence] @returns {Follow['proposals'][number]} */
const row = (frame, confidence = 0.9) => [frame, ...at(frame), confidence, 'matched'];
const follow = () => newFollowing({ key: 'h1', anchors: [{ frame: 50, box: at(50) }], only: null, first: 0, last: null });

test('proposals are added, replaced and withdrawn; the accepted span has no gap', () => {
  let now = withAnswer(follow(), answer({ proposals: [row(51), row(49), row(52), row(54)] }));
  assert.deepEqual(acceptedSpan(now), { first: 49, last: 52 });
  now = withAnswer(now, answer({ proposals: [row(53), row(51, 0.4)], next: 2 }));
  assert.deepEqual([acceptedSpan(now), now.proposals[51].confidence, proposedFrameCount(now)], [{ first: 49, last: 54 }, 0.4, 5]);
  now = withAnswer(
    now,
    answer({ state: 'complete', endings: [{ direction: 'forward', frame: 52, reason: 'gone', sentence: 'It is gone.' }] }),
  );
  assert.deepEqual(acceptedSpan(now), { first: 49, last: 52 });
  assert.equal(proposalAt(now, 53), null);
  assert.equal(describeFollowing(now, '#1'), 'Proposal for track #1: frames 49 to 52, 3 new. It is gone.');
});

test('a cut keeps the anchor, whatever frame it is made in', () => {
  const now = withAnswer(follow(), answer({ proposals: [row(48), row(49), row(51), row(52)] }));
  assert.deepEqual(acceptedSpan(withCut(now, 'from', 49)), { first: 49, last: 52 });
  assert.deepEqual(acceptedSpan(withCut(now, 'to', 30)), { first: 48, last: 50 });
  assert.deepEqual(acceptedSpan(withCut(withCut(now, 'from', 99), 'to', 0)), { first: 50, last: 50 });
  assert.equal(acceptCommand(withCut(withCut(now, 'from', 50), 'to', 50), 50), null);
});

test('few boxes stand for many, within half a pixel at each edge', () => {
  const dense = Array.from({ length: 101 }, (_, frame) => ({ frame, box: at(frame) }));
  const few = thinBoxes(dense, new Set([50]));
  assert.ok(few.length < 30 && few.some(({ frame }) => frame === 50), `${few.length} boxes`);
  assert.deepEqual([few[0].frame, few.at(-1)?.frame], [0, 100]);
  const keys = Object.fromEntries(few.map(({ frame, box }) => [frame, key({ box })]));
  for (const { frame, box } of dense) {
    const shown = boxAt({ ...blankDoc('h1'), keys }, frame, () => null)?.box;
    assert.ok(shown && shown.every((edge, i) => Math.abs(edge - box[i]) <= 0.5), `frame ${frame}`);
  }
});

test('an accepted follow shows the proposed boxes, and the engine’s boxes outside its span', () => {
  const following = withAnswer(
    newFollowing({ key: 'm1', anchors: [{ frame: 50, box: at(50) }], only: 'backward', first: 0, last: null }),
    answer({ key: 'm1', proposals: Array.from({ length: 30 }, (_, i) => row(49 - i)) }),
  );
  const command = acceptCommand(following, 50);
  assert.ok(command);
  const { docs } = applyCommand({ m1: emptyDoc({ track: 1, first: 50, last: 90 }) }, command, { author: 'a', time: '' });
  /** @param {number} frame */
  const shown = (frame) => boxAt(docs.m1, frame, () => [0, 0, 9, 9]);
  assert.equal(shown(19), null);
  for (let frame = 20; frame <= 50; frame += 1)
    assert.ok(
      shown(frame)?.box.every((edge, i) => Math.abs(edge - at(frame)[i]) <= 0.5),
      `frame ${frame}`,
    );
  assert.deepEqual(shown(51), { box: [0, 0, 9, 9], origin: 'engine', occluded: false, class_id: null });
  assert.deepEqual([docs.m1.keys[50].followed, docs.m1.keys[20].followed], [false, true]);
});

test('a correction is followed between the neighbouring manual boxes, never into frames marked as outside', () => {
  const doc = {
    ...blankDoc('h1'),
    keys: { 10: key(), 20: key({ followed: true }), 40: key(), 70: key({ outside: true, box: null }), 80: key() },
  };
  assert.deepEqual(anchorsAround(doc, 30), { before: { frame: 10, box: at(0) }, after: { frame: 40, box: at(0) } });
  assert.deepEqual(followRange(doc, 30), { first: 0, last: 69 });
  assert.deepEqual(followRange(doc, 85), { first: 80, last: null });
  const request = requestFrom(doc, 'h1', { frame: 30, box: at(30) }, null);
  assert.deepEqual([request.anchors.map(({ frame }) => frame), request.first, request.last], [[10, 30, 40], 10, 40]);
  const late = requestFrom(doc, 'h1', { frame: 60, box: at(60) }, null);
  assert.deepEqual([late.anchors.map(({ frame }) => frame), late.first, late.last], [[40, 60], 40, 69]);
  assert.deepEqual(pluck(requestFrom(doc, 'h1', { frame: 60, box: at(60) }, 'forward').anchors, 'frame'), [60]);
  const more = requestWith({ ...follow(), first: 40, last: 60 }, { frame: 55, box: at(55) });
  assert.deepEqual([more.anchors.map(({ frame }) => frame), more.first, more.last], [[50, 55], 40, 60]);
});

test('progress, failure and an empty result are described', () => {
  assert.equal(describeFollowing(follow(), '#1'), 'Following track #1');
  assert.equal(describeFollowing(withAnswer(follow(), answer({ note: 'compiling' })), '#1'), 'Following track #1 · compiling');
  assert.equal(
    describeFollowing(withAnswer(follow(), answer({ state: 'failed', error: 'The file is gone.' })), '#1'),
    'Track #1 could not be followed: The file is gone.',
  );
  assert.equal(describeFollowing(withAnswer(follow(), answer({ state: 'complete' })), '#1'), 'Track #1 is not found in another frame.');
});

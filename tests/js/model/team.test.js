// @ts-check
import assert from 'node:assert/strict';
import { test } from 'node:test';
import {
  tracksPerHour,
  describeDifference,
  assignedFrames,
  hasRole,
  nextAssignment,
  readOnlyReason,
  assignmentsToReview,
  currentAssignment,
  waitingAssignments,
} from '../../../static/js/model/team.js';
import { formatRoute, parseRoute } from '../../../static/js/model/route.js';
import { afterEvent } from '../../../static/js/store/catch_up.js';
import { initialState } from '../../../static/js/store/initial.js';
import { labelsNamed } from '../labels.js';
import { pluck } from '../pluck.js';

/** @param {any} fields @returns {import('../../../static/js/types.js').Assignment} */
const work = (fields) => ({
  video_id: 'v',
  video_name: 'drive.mp4',
  person: 'ann',
  first: 0,
  stop: null,
  state: 'assigned',
  comment: '',
  changed_by: 'rolf',
  revision: 1,
  created: '',
  changed: '',
  ...fields,
});
/** @param {any} role @param {string} [name] @returns {any} */
const session = (role, name = 'ann') => ({ person: { name, role, can_sign_out: true } });

test('a role may what those below it may, and without people everybody may everything', () => {
  assert.deepEqual(
    ['viewer', 'annotator', 'reviewer', 'admin'].map((role) => hasRole(session(role), 'reviewer')),
    [false, false, true, true],
  );
  assert.equal(hasRole(/** @type {any} */ ({ person: null }), 'admin'), true);
  assert.equal(hasRole(null, 'admin'), true);
  assert.match(readOnlyReason(session('viewer')) ?? '', /change nothing/);
  assert.equal(readOnlyReason(session('annotator')), null);
});

test('returned assignments come first, then the oldest; reviewers see those handed in', () => {
  const all = [
    work({ id: 3 }),
    work({ id: 2, state: 'in_review' }),
    work({ id: 5, state: 'returned' }),
    work({ id: 1 }),
    work({ id: 4, person: 'bob', state: 'in_review' }),
    work({ id: 6, state: 'done' }),
  ];
  assert.deepEqual(pluck(waitingAssignments(all, 'ann'), 'id'), [5, 1, 3]);
  assert.deepEqual(pluck(assignmentsToReview(all, 'ann'), 'id'), [4]);
});

test('the next assignment is the one after the open one; after the last, the first', () => {
  const all = [work({ id: 1 }), work({ id: 2 }), work({ id: 3, person: 'bob', state: 'in_review' })];
  const next = (/** @type {any} */ who, /** @type {number|null} */ open) => nextAssignment(all, who, open)?.id ?? null;
  assert.deepEqual(
    [null, 1, 2, 9].map((open) => next(session('annotator'), open)),
    [1, 2, 1, 1],
  );
  assert.deepEqual(
    [2, 3].map((open) => next(session('reviewer'), open)),
    [3, 1],
  );
  assert.equal(nextAssignment([work({ id: 1 })], session('annotator'), 1), null);
  assert.equal(nextAssignment(all, /** @type {any} */ ({ person: null }), null), null);
});

test('of several assignments of a video the one that holds the frame is shown, one’s own first', () => {
  const all = [
    work({ id: 1, first: 0, stop: 10 }),
    work({ id: 2, first: 10 }),
    work({ id: 3, person: 'bob', state: 'in_review' }),
    work({ id: 4, person: 'bob' }),
  ];
  const here = (/** @type {any} */ who, /** @type {number} */ frame) => currentAssignment(all, who, 'v', frame)?.id ?? null;
  assert.deepEqual([here(session('annotator'), 9), here(session('annotator'), 10)], [1, 2]);
  assert.equal(here(session('reviewer', 'rolf'), 5), 3);
  assert.equal(here(session('annotator', 'eve'), 5), null);
  assert.equal(currentAssignment(all, session('annotator'), 'other', 5), null);
});

test('frames and speed in words', () => {
  assert.deepEqual(
    [
      [0, null],
      [7, null],
      [3, 9],
    ].map(([first, stop]) => assignedFrames(/** @type {any} */ ({ first, stop }))),
    ['all frames', 'from frame 7', 'frames 3 to 8'],
  );
  assert.deepEqual(
    [tracksPerHour({ decided: 30, hours: 0.5 }), tracksPerHour({ decided: 3, hours: 0.01 }), tracksPerHour({ decided: 0, hours: 2 })],
    [60, null, null],
  );
});

test('a difference is one line', () => {
  const labels = labelsNamed(['stop', 'yield']);
  /** @param {string} what @param {any} before @param {any} after @param {number} [more] */
  const words = (what, before, after, more = 0) => describeDifference({ what, before, after, more }, labels);
  assert.equal(words('label', null, 1), 'Label: the engine’s → yield');
  assert.equal(words('review', 'open', 'rejected'), 'Verdict: undecided → false positive');
  assert.equal(words('deleted', false, true), 'Deleted');
  assert.equal(words('not a sign', true, false), 'No longer not a sign');
  assert.equal(words('merged into', null, 'm7'), 'Merged into track #7');
  assert.equal(words('boxes', {}, { 5: [1, 2, 3.25, 4] }), 'Box in frame 5: 1, 2, 3.3, 4');
  assert.equal(words('boxes', { 5: [0, 0, 1, 1] }, { 5: [1, 2, 3, 4] }), 'Box in frame 5: 0, 0, 1, 1 → 1, 2, 3, 4');
  assert.equal(
    words('boxes', { 7: [0, 0, 1, 1] }, { 5: [1, 2, 3, 4], 6: [1, 2, 3, 4] }, 4),
    'Boxes: set in frames 5, 6, removed in frames 7 and 4 more',
  );
  assert.equal(words('notes', {}, { n: 'ann, frame 5: bent' }), 'Note: “ann, frame 5: bent”');
  assert.equal(words('attributes', { bent: true }, { bent: false }), 'Attributes: bent “true” → “false”');
  assert.equal(words('occluded', [1, 2], [2, 9]), 'Occluded: set at 9, removed at 1');
});

test('the address of a person survives any name', () => {
  for (const person of [null, 'Ann', 'a/b?c#d %', 'Zoë']) {
    assert.deepEqual(parseRoute(formatRoute({ screen: 'team', person })), { screen: 'team', person });
  }
});

test('events change assignments, and an older answer does not overwrite them', () => {
  const event = (/** @type {string} */ kind, /** @type {any} */ data) => /** @type {any} */ ({ seq: 1, kind, subject: '1', data });
  let state = afterEvent(initialState(), event('assignment', work({ id: 1, revision: 2, state: 'in_review' })));
  state = afterEvent(state, event('assignment', work({ id: 1, revision: 1 })));
  assert.deepEqual(
    state.assignments.map(({ state: now }) => now),
    ['in_review'],
  );
  assert.deepEqual(afterEvent(state, event('removed', { kind: 'assignment', id: 1 })).assignments, []);
});

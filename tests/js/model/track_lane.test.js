// @ts-check
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { blankDoc } from '../../../static/js/model/documents.js';
import { documentLane, sentencesOfTrack } from '../../../static/js/model/track_lane.js';
import { syntheticRun, syntheticLane } from '../harness/synthetic_run.js';
import { rowsOf } from '../pluck.js';

/** @typedef {import('../../../static/js/types.js').TrackLane} TrackLane */

/**
 * A lane whose votes are those of its frames, as the engine's are.
 *
 * @param {number} id
 * @param {number} first
 * @param {number[]} classes
 * @param {([number, number[]]|null)[]} read   weight and P of `classes`, frame by frame; null: not recognised
 * @returns {TrackLane}
 */
function lane(id, first, classes, read) {
  const { tracks } = syntheticRun(1000, 1);
  const made = syntheticLane({ ...tracks, id: [id], first: [first], last: [first + read.length - 1] }, 0);
  let weights = 0;
  const sums = classes.map(() => 0);
  /** @type {TrackLane['votes']} */
  const votes = read.map((one) => {
    if (one === null) return null;
    weights += one[0];
    one[1].forEach((p, c) => {
      sums[c] += one[0] * p;
    });
    return sums.map((sum) => sum / weights);
  });
  const best = read.map((one) => one && Math.max(...one[1]));
  const top = read.map((one, i) => one && classes[one[1].indexOf(best[i] ?? 0)]);
  return {
    ...made,
    classes,
    votes,
    top,
    top_probability: best,
    weight: read.map((one) => one && one[0]),
    probabilities: read.map((one) => one && one[1]),
    events: [{ frame: first, kind: 'born', text: `Track ${id} is born.` }],
  };
}

const SEVEN = lane(7, 10, [14, 13], [[1, [0.9, 0.1]], null, [3, [0.7, 0.3]], [2, [0.2, 0.8]], [2, [0.1, 0.9]]]);
const NINE = lane(
  9,
  20,
  [13, 5],
  [
    [4, [0.6, 0.4]],
    [4, [0.5, 0.5]],
  ],
);
const LANES = { 7: SEVEN, 9: NINE };

/** @param {[number, number, number][]} pieces @param {string} [key] */
const cut = (pieces, key = 'm7') => ({ ...blankDoc(key), segments: pieces.map(([track, first, last]) => ({ track, first, last })) });
/** @param {TrackLane['votes'][number]} votes */
const rounded = (votes) => votes && votes.map((share) => Number(share.toFixed(6)));

test('a track that nobody touched has the engine’s lane itself', () => {
  for (const doc of [undefined, cut([[7, 10, 14]]), cut([[7, 0, 2 ** 31 - 2]])]) {
    const found = documentLane('m7', doc, LANES);
    assert.equal(found?.lane, SEVEN);
    assert.deepEqual([found?.whole, found?.track], [true, [7, 7, 7, 7, 7]]);
  }
  assert.equal(documentLane('m8', undefined, LANES), null);
  assert.equal(documentLane('hab', blankDoc('hab'), LANES), null);
});

test('the halves of a split have their own frames and their own votes', () => {
  const head = documentLane('m7', cut([[7, 10, 12]]), LANES);
  assert.deepEqual(head?.lane.frame, [10, 11, 12]);
  assert.deepEqual([head?.lane.tau, head?.lane.symmetry_floor], [SEVEN.tau, SEVEN.symmetry_floor]);
  assert.deepEqual(head?.lane.votes.map(rounded), [[0.9, 0.1], null, [0.75, 0.25]]);
  assert.deepEqual(head?.reading && [head.reading.class_id, head.reading.runner_up], [14, 13]);
  const tail = documentLane('hab', cut([[7, 13, 14]], 'hab'), LANES);
  assert.deepEqual(tail?.lane.frame, [13, 14]);
  assert.deepEqual(tail?.lane.box, SEVEN.box.slice(3));
  assert.deepEqual(tail?.lane.l_positive, SEVEN.l_positive.slice(3));
  // the whole track leads with 14; these frames alone do not
  assert.deepEqual(tail?.lane.classes, [13, 14]);
  assert.deepEqual(tail?.lane.votes.map(rounded), [
    [0.8, 0.2],
    [0.85, 0.15],
  ]);
  assert.deepEqual(tail?.lane.probabilities, [
    [0.8, 0.2],
    [0.9, 0.1],
  ]);
  assert.equal(Number(tail?.reading?.share.toFixed(6)), 0.85);
});

test('a track that was split and merged again is whole', () => {
  const found = documentLane(
    'm7',
    cut([
      [7, 12, 14],
      [7, 10, 11],
    ]),
    LANES,
  );
  assert.deepEqual([found?.whole, found?.lane], [true, SEVEN]);
  const apart = documentLane(
    'm7',
    cut([
      [7, 10, 11],
      [7, 13, 14],
    ]),
    LANES,
  );
  assert.deepEqual([apart?.whole, apart?.lane.frame], [false, [10, 11, 13, 14]]);
});

test('two tracks that were merged vote together, and each frame knows whose it is', () => {
  const found = documentLane(
    'm7',
    cut([
      [9, 20, 21],
      [7, 13, 14],
    ]),
    LANES,
  );
  assert.deepEqual(found?.lane.frame, [13, 14, 20, 21]);
  assert.deepEqual(found?.track, [7, 7, 9, 9]);
  assert.deepEqual(found?.lane.classes, [13, 5, 14]);
  assert.deepEqual(
    rounded(found?.lane.votes[3] ?? null),
    [7.8 / 12, 3.6 / 12, 0.6 / 12].map((share) => Number(share.toFixed(6))),
  );
  assert.deepEqual(found?.lane.probabilities[2], [0.6, 0.4, 0]);
  // a part is not said to be the whole
  assert.equal(
    documentLane(
      'm7',
      cut([
        [9, 20, 21],
        [7, 13, 14],
      ]),
      { 9: NINE },
    ),
    null,
  );
});

test('the class of a frame counts even if it is not among the leading classes of the track', () => {
  const long = lane(
    8,
    0,
    [1, 2, 3, 4, 5, 6],
    [
      ...Array.from({ length: 40 }, () => /** @type {[number, number[]]} */ ([1, [0.9, 0.02, 0.02, 0.02, 0.02, 0.02]])),
      [1, [0.02, 0.01, 0.01, 0.01, 0.01, 0]],
      [1, [0.02, 0.01, 0.01, 0.01, 0.01, 0]],
    ],
  );
  long.top = long.frame.map((frame) => (frame < 40 ? 1 : 33));
  long.top_probability = long.frame.map(() => 0.9);
  const tail = documentLane('hab', cut([[8, 40, 41]], 'hab'), { 8: long });
  assert.deepEqual([tail?.reading?.class_id, Number(tail?.reading?.share.toFixed(6))], [33, 0.9]);
  assert.equal(tail?.lane.probabilities[0]?.[0], 0.9);
});

test('the same lanes give the same object', () => {
  const doc = cut([[7, 10, 12]]);
  const found = documentLane('m7', doc, LANES);
  assert.equal(
    documentLane('m7', { ...cut([[7, 10, 12]]), review: 'accepted' }, { ...LANES, 8: NINE }),
    found,
    'as the server sends it anew',
  );
  assert.notEqual(documentLane('m7', doc, { ...LANES, 7: { ...SEVEN } }), found);
});

test('sentences cover the remaining frames and name the cuts and joins', () => {
  const found = documentLane(
    'm7',
    cut([
      [7, 12, 13],
      [9, 20, 21],
    ]),
    LANES,
  );
  const reported = found ? sentencesOfTrack(found).filter(({ kind }) => kind === 'joined' || kind === 'cut' || kind === 'born') : [];
  assert.deepEqual(rowsOf(reported, 'frame', 'kind', 'text'), [
    [12, 'joined', 'from here on this is the engine’s track #7'],
    [13, 'cut', 'the engine’s track #7 continues, but not in this track'],
    [20, 'joined', 'from here on this is the engine’s track #9'],
    [20, 'born', 'born'],
  ]);
});

test('how the engine’s track ended is reported in its last part', () => {
  const died = { ...SEVEN, events: [...SEVEN.events, { frame: 15, kind: 'died', text: 'Track 7 has had no detection for 20 frames.' }] };
  /** @param {[number, number, number][]} pieces */
  const kinds = (pieces) => {
    const found = documentLane('m7', cut(pieces), { 7: died });
    return [
      found
        ? sentencesOfTrack(found)
            .map(({ kind }) => kind)
            .filter((kind) => kind === 'died' || kind === 'born')
        : [],
      found?.lane.events.map(({ kind }) => kind),
    ];
  };
  assert.deepEqual(kinds([[7, 12, 14]]), [['died'], ['died']]);
  assert.deepEqual(kinds([[7, 10, 12]]), [['born'], ['born']]);
  assert.deepEqual(kinds([[7, 11, 13]]), [[], []]);
});

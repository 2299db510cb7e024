// @ts-check
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { OPEN_END, blankDoc } from '../../../static/js/model/documents.js';
import { boxAt } from '../../../static/js/model/effective.js';
import { describeCorrectionAt } from '../../../static/js/model/describe_corrections.js';
import { intersectSpans, countFrames, shownSpans } from '../../../static/js/model/shown_spans.js';
import { seededRandom } from '../harness/synthetic_run.js';
import { keyFrame } from '../server_data.js';

/** @typedef {import('../../../static/js/types.js').Box} Box */
const BOX = /** @type {Box} */ ([0, 0, 9, 9]);
/** @param {[number, number][]} pieces @param {Record<string, object>} keys */
const doc = (pieces, keys) => ({
  ...blankDoc('m7'),
  segments: pieces.map(([first, last]) => ({ track: 7, first, last })),
  keys: Object.fromEntries(Object.entries(keys).map(([frame, change]) => [frame, keyFrame({ interpolate: false, ...change })])),
});

/** @type {[string, ReturnType<typeof doc>, [number, number][]][]} */
const CASES = [
  ['an engine’s track', doc([[10, 20]], {}), [[10, 20]]],
  ['out of sight to the end', doc([[10, 20]], { 15: { outside: true } }), [[10, 14]]],
  [
    'out of sight for a while',
    doc([[10, 20]], { 12: { outside: true }, 15: {} }),
    [
      [10, 11],
      [15, 20],
    ],
  ],
  [
    'a box beyond its end',
    doc([[10, 20]], { 25: { box: BOX } }),
    [
      [10, 20],
      [25, 25],
    ],
  ],
  ['a line beyond its end', doc([[10, 20]], { 18: { box: BOX, interpolate: true }, 25: { box: BOX } }), [[10, 25]]],
  [
    'a line that ends out of sight',
    doc([], { 3: { box: BOX, interpolate: true }, 6: { box: BOX, interpolate: true }, 9: { outside: true } }),
    [[3, 6]],
  ],
  ['all of it out of sight', doc([[10, 20]], { 10: { outside: true } }), []],
  [
    'two pieces',
    doc(
      [
        [10, 12],
        [15, 20],
      ],
      {},
    ),
    [
      [10, 12],
      [15, 20],
    ],
  ],
];
for (const [name, given, runs] of CASES) {
  test(`shown: ${name}`, () => {
    assert.deepEqual(shownSpans(given), runs);
    // the same as asking for each frame
    const frames = Array.from({ length: 40 }, (_, frame) => frame).filter((frame) => boxAt(given, frame, () => BOX) !== null);
    assert.deepEqual(
      runs.flatMap(([first, last]) => Array.from({ length: last - first + 1 }, (_, i) => first + i)),
      frames,
    );
    assert.equal(countFrames(runs), frames.length);
    assert.equal(countFrames(runs, 12, 15), frames.filter((frame) => frame >= 12 && frame <= 15).length);
  });
}

test('shown: whatever people have said, the same as asking for each frame', () => {
  const next = seededRandom(11);
  for (let round = 0; round < 400; round += 1) {
    /** @type {Record<string, object>} */
    const keys = {};
    for (let frame = 0; frame < 30; frame += 1) {
      if (next() < 0.25) keys[frame] = { box: next() < 0.6 ? BOX : null, outside: next() < 0.25, interpolate: next() < 0.6 };
    }
    const given = doc(
      next() < 0.5
        ? [
            [5, 12],
            [15, 22],
          ]
        : [],
      keys,
    );
    const frames = Array.from({ length: 40 }, (_, frame) => frame).filter((frame) => boxAt(given, frame, () => BOX) !== null);
    const runs = shownSpans(given);
    assert.deepEqual(
      runs.flatMap(([first, last]) => Array.from({ length: last - first + 1 }, (_, i) => first + i)),
      frames,
      JSON.stringify(given),
    );
    assert.equal(shownSpans(given), runs, 'the same list for the same document');
  }
});

test('a track that may still grow is shown as far as it has come', () => {
  const growing = doc([[10, OPEN_END]], { 30: { outside: true } });
  assert.deepEqual(
    shownSpans(growing, () => 24),
    [[10, 24]],
  );
  assert.deepEqual(
    shownSpans(growing, () => 99),
    [[10, 29]],
  );
  assert.deepEqual(shownSpans({ ...growing, gone: true }), []);
});

test('corrections in a frame are described', () => {
  const given = doc([[0, 60]], {
    10: { box: BOX, interpolate: true },
    20: { box: BOX, occluded: true },
    30: { outside: true },
    40: { occluded: true },
    50: {},
  });
  for (const [frame, text] of /** @type {[number, string|null][]} */ ([
    [5, null],
    [10, 'A person put the box here.'],
    [15, 'The box is interpolated between a person’s boxes in frames 10 and 20.'],
    [20, 'A person put the box here. A person marked it as partly hidden.'],
    [25, 'A person marked it as partly hidden.'],
    [30, 'A person marked it as outside.'],
    [33, 'A person marked it as outside from frame 30 on.'],
    [45, 'A person marked it as partly hidden.'],
    [55, null],
  ]))
    assert.equal(describeCorrectionAt(given, frame), text, `frame ${frame}`);
});

test('frames in which two tracks show something', () => {
  assert.equal(
    countFrames(
      intersectSpans(
        [
          [0, 9],
          [20, 29],
        ],
        [[5, 24]],
      ),
    ),
    10,
  );
  assert.deepEqual(intersectSpans([[0, 9]], [[10, 19]]), []);
  assert.deepEqual(intersectSpans([], [[0, 5]]), []);
});

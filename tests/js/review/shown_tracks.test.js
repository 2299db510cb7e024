// @ts-check
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { applyCommand } from '../../../static/js/model/commands.js';
import { isCorrected } from '../../../static/js/model/corrected.js';
import { shownTracks } from '../../../static/js/review/shown_tracks.js';

const tracks = /** @type {any} */ ({ id: [7], first: [0], last: [99] });
const spans = [{ track: 7, first: 0, last: 99 }];
const person = { author: 'a', time: '' };

test('a verdict or a note leaves a track as the engine has it; a box, a class or a cut does not', () => {
  for (const [corrected, command] of /** @type {[boolean, any][]} */ ([
    [false, { name: 'set_review', review: 'accepted' }],
    [false, { name: 'add_note', note_id: 'n', text: 'faded' }],
    [true, { name: 'set_box', box: [1, 1, 9, 9] }],
    [true, { name: 'relabel_track', class_id: 14 }],
    [true, { name: 'delete_from' }],
    [true, { name: 'split', new_key: 'h1' }],
    [true, { name: 'set_not_a_sign', value: true }],
  ])) {
    const { docs } = applyCommand({}, { frame: 40, key: 'm7', spans, ...command }, person);
    for (const doc of Object.values(docs)) assert.equal(isCorrected(doc, tracks), corrected, command.name);
  }
});

/**
 * Which boxes of the tracks m7 and m8 are in the layer of corrections, by frame.
 *
 * @param {any[]} commands
 * @param {number[]} frames
 */
function editedFlags(commands, frames) {
  const both = { id: [7, 8], first: [0, 60], last: [50, 99], class_id: [14, 13] };
  const all = [
    { track: 7, first: 0, last: 50 },
    { track: 8, first: 60, last: 99 },
  ];
  /** @type {Record<string, any>} */
  let docs = {};
  for (const command of commands) ({ docs } = applyCommand(docs, { key: 'm7', spans: all, ...command }, person));
  /** @param {number} frame */
  const overlay = (frame) => ({
    tracks: both.id.flatMap((id, i) =>
      both.first[i] <= frame && frame <= both.last[i]
        ? [{ id, state: 'confirmed', box: [frame, 0, frame + 9, 9], class_id: both.class_id[i] }]
        : [],
    ),
  });
  const review = /** @type {any} */ ({ docs, tracks: both, overlays: Object.fromEntries(frames.map((frame) => [frame, overlay(frame)])) });
  return frames.map((frame) => shownTracks(review, frame).map((shown) => shown.edited));
}

test('one corrected frame leaves the other boxes the engine’s', () => {
  const box = [1, 1, 9, 9];
  assert.deepEqual(editedFlags([{ name: 'add_key', frame: 20, box }], [19, 20, 21]), [[false], [true], [false]]);
  assert.deepEqual(
    editedFlags(
      [
        { name: 'set_box', frame: 20, box },
        { name: 'set_box', frame: 24, box },
        { name: 'interpolate', frame: 20, first: 20, last: 24 },
      ],
      [19, 20, 22, 24, 25],
    ),
    [[false], [true], [true], [true], [false]],
  );
  assert.deepEqual(editedFlags([{ name: 'set_review', frame: 20, review: 'accepted' }], [20]), [[false]]);
});

test('a label of one box is that box’s, one of the track is every box’s', () => {
  assert.deepEqual(editedFlags([{ name: 'relabel_box', frame: 20, class_id: 1 }], [19, 20, 21]), [[false], [true], [false]]);
  assert.deepEqual(editedFlags([{ name: 'relabel_track', frame: 20, class_id: 1 }], [0, 20]), [[true], [true]]);
  assert.deepEqual(
    editedFlags([{ name: 'relabel_track', frame: 20, class_id: 14 }], [0, 20]),
    [[false], [false]],
    'what the engine says too',
  );
  assert.deepEqual(editedFlags([{ name: 'set_not_a_sign', frame: 20, value: true }], [0]), [[true]]);
  assert.deepEqual(editedFlags([{ name: 'set_occluded', frame: 20, value: true }], [19, 20, 21]), [[false], [true], [true]]);
});

test('cut and joined tracks have the engine’s boxes, joined ones with the label that is theirs now', () => {
  assert.deepEqual(editedFlags([{ name: 'split', frame: 20, new_key: 'h1' }], [19, 20]), [[false], [false]]);
  assert.deepEqual(editedFlags([{ name: 'merge', frame: 70, others: ['m8'] }], [40, 70]), [[false], [true]]);
});

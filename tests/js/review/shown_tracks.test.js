// @ts-check
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { applyCommand } from '../../../static/js/model/commands.js';
import { isCorrected } from '../../../static/js/review/shown_tracks.js';

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

// @ts-check
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { applyCommand } from '../../../static/js/model/commands.js';
import { trackName } from '../../../static/js/model/track_name.js';

const person = { author: 'a', time: '' };

test('a track is named by its number or its origin, never by its key', () => {
  const spans = [{ track: 7, first: 0, last: 99 }];
  const cut = applyCommand({}, { name: 'split', key: 'm7', frame: 40, new_key: 'h0c4f', spans }, person).docs;
  const made = applyCommand(cut, { name: 'create_track', key: 'h9a', frame: 88, box: [1, 1, 9, 9], class_id: null }, person).docs;
  assert.deepEqual(
    ['m7', 'h0c4f', 'h9a', 'hgone'].map((key) => trackName(key, made[key])),
    ['#7', '#7 from 40', 'drawn at 88', 'made by hand'],
  );
});

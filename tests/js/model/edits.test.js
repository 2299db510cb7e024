// @ts-check
import assert from 'node:assert/strict';
import { readFileSync, readdirSync } from 'node:fs';
import { test } from 'node:test';

import { CommandError, applyCommand, touchedKeys } from '../../../static/js/model/commands.js';
import { OPEN_END, attributesAt, emptyDoc, keyFrameBoxAt, keyFramesOf } from '../../../static/js/model/documents.js';
import { boxAt, spanOf, subjectOf } from '../../../static/js/model/effective.js';
import { keyFrame } from '../server_data.js';

const FOLDER = new URL('../../golden/edits/', import.meta.url);

for (const file of readdirSync(FOLDER)) {
  const golden = JSON.parse(readFileSync(new URL(file, FOLDER), 'utf8'));
  /** @type {(track: number, frame: number) => import('../../../static/js/types.js').Box|null} */
  const machine = (track, frame) => {
    const [first, last] = golden.spans[track];
    if (frame < first || frame > last || frame % 7 === 6) return null;
    return [100 * track + frame, 10, 100 * track + frame + 20, 30];
  };
  for (const { name, docs, command, person, expected, error, shown } of golden.cases) {
    test(`${file}: ${name}`, () => {
      const before = structuredClone(docs);
      if (error) {
        assert.throws(() => applyCommand(docs, command, person), { name: 'CommandError', message: error });
        return;
      }
      const answer = applyCommand(docs, command, person);
      const changed = Object.fromEntries(answer.changed.map((key) => [key, answer.docs[key]]));
      assert.deepEqual(changed, expected);
      assert.deepEqual(docs, before, 'what came in was changed');
      assert.ok(answer.changed.every((key) => touchedKeys(command).includes(key)));
      for (const [key, frame, want, attributes = {}] of shown) {
        assert.deepEqual(attributesAt(answer.docs[key], frame), attributes, `${key} at ${frame}`);
        const got = boxAt(answer.docs[key], frame, machine);
        const flat = got && [got.box, got.origin, got.occluded, got.class_id];
        assert.deepEqual(flat, want, `${key} at ${frame}`);
      }
    });
  }
}

test('an engine track without a document is taken from the spans of the command', () => {
  const spans = [{ track: 4, first: 2, last: 9 }];
  const command = { name: /** @type {const} */ ('delete_from'), frame: 5, key: 'm4', spans };
  const { docs, changed } = applyCommand({}, command, { author: 'a', time: '' });
  assert.deepEqual(changed, ['m4']);
  assert.deepEqual(docs.m4.segments, [{ track: 4, first: 2, last: 4 }]);
});

test('a command for a track that is not there is refused with a sentence', () => {
  const command = { name: /** @type {const} */ ('delete_track'), frame: 5, key: 'm4' };
  assert.throws(() => applyCommand({}, command, { author: 'a', time: '' }), CommandError);
});

test('span and key frames', () => {
  const open = emptyDoc({ track: 4, first: 2, last: 9 }, true);
  assert.equal(open.segments[0].last, OPEN_END);
  assert.deepEqual(
    spanOf(open, () => 30),
    { first: 2, last: 30 },
  );
  const doc = {
    ...emptyDoc({ track: 4, first: 2, last: 9 }),
    keys: { 20: keyFrame({ box: [10, 0, 11, 1] }), 10: keyFrame({ box: [0, 0, 1, 1] }) },
  };
  assert.deepEqual(spanOf(doc), { first: 2, last: 20 });
  assert.deepEqual(keyFramesOf(doc), [10, 20]);
  assert.deepEqual(keyFrameBoxAt(doc, 15), [5, 0, 6, 1]);
  assert.equal(spanOf({ ...doc, gone: true }), null);
});

test('a split done again is about the half that its frame lies in; without a frame about the first that is left', () => {
  const docs = { m4: emptyDoc({ track: 4, first: 2, last: 9 }, true) };
  const halves = applyCommand(docs, { name: 'split', key: 'm4', frame: 6, new_key: 'p-late' }, { author: 'a', time: '' });
  const both = Object.values(halves.docs);
  assert.equal(subjectOf(both, 6)?.key, 'p-late');
  assert.equal(subjectOf(both, 5)?.key, 'm4');
  assert.equal(subjectOf(both, null)?.key, both[0].key);
  assert.equal(subjectOf([{ ...both[0], gone: true }], 5), null);
});

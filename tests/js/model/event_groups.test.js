// @ts-check
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { groupEvents } from '../../../static/js/model/event_groups.js';
import { rowsOf } from '../pluck.js';

/** @param {number} frame @param {string} kind */
const at = (frame, kind) => ({ frame, kind, text: `${kind} ${frame}` });

test('events that repeat in neighbouring frames are one line, also beside other events', () => {
  const found = groupEvents([
    at(3, 'born'),
    at(10, 'relocalised'),
    at(11, 'relocalised'),
    at(11, 'unlearned'),
    at(12, 'relocalised'),
    at(14, 'died'),
  ]);
  assert.deepEqual(
    found.map((one) => [one.kind, one.frame, one.last, one.sentences.length]),
    [
      ['born', 3, 3, 1],
      ['relocalised', 10, 12, 3],
      ['unlearned', 11, 11, 1],
      ['died', 14, 14, 1],
    ],
  );
  assert.equal(found[1].sentences[2].text, 'relocalised 12');
});

test('two stay apart, a gap of a frame ends a stretch, and what happens once is never joined', () => {
  const found = groupEvents([
    at(1, 'rejected'),
    at(2, 'rejected'),
    at(4, 'rejected'),
    at(5, 'relabelled'),
    at(6, 'relabelled'),
    at(7, 'relabelled'),
  ]);
  assert.deepEqual(rowsOf(found, 'kind', 'frame', 'last'), [
    ['rejected', 1, 1],
    ['rejected', 2, 2],
    ['rejected', 4, 4],
    ['relabelled', 5, 5],
    ['relabelled', 6, 6],
    ['relabelled', 7, 7],
  ]);
  assert.deepEqual(groupEvents([]), []);
});

test('nothing is lost and the order is that of the first frames', () => {
  const given = Array.from({ length: 40 }, (_, i) => at(Math.floor(i / 2), ['rejected', 'unlearned', 'relocalised'][(i * 7) % 3]));
  const found = groupEvents(given);
  assert.equal(
    found.reduce((all, one) => all + one.sentences.length, 0),
    given.length,
  );
  assert.ok(found.every((one, i) => i === 0 || found[i - 1].frame <= one.frame));
  assert.ok(found.every((one) => one.sentences.every((s) => s.kind === one.kind && one.frame <= s.frame && s.frame <= one.last)));
});

// @ts-check
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { regressions, figureGroups } from '../../../static/js/model/model_figures.js';
import { pluck, rowsOf } from '../pluck.js';

test('figures stand beside the earlier ones, with better and worse by their meaning', () => {
  const [group] = figureGroups({
    corrections: {
      by: 'sign',
      signs: 4,
      new: { ap50: 0.8, mean_eq7: 0.12, recall_at_1: 0.9, pictures: 40 },
      parent: { ap50: 0.7, mean_eq7: 0.1, recall_at_1: 0.9002 },
    },
    worse: ['x'],
  });
  assert.equal(group.title, 'Held-out corrections');
  assert.equal(group.of, '40 pictures.');
  assert.deepEqual(rowsOf(group.rows, 'name', 'now', 'before', 'verdict'), [
    ['ap50', 0.8, 0.7, 'better'],
    ['mean_eq7', 0.12, 0.1, 'worse'],
    ['recall_at_1', 0.9, 0.9002, 'same'],
  ]);
});

test('a version without an earlier one has values alone, nested ones too', () => {
  const groups = figureGroups({ prior: { raw: { ap50: 0.9, pictures: 3 }, with_prior: { ap50: 0.95 } }, online: {}, memory: {} });
  assert.deepEqual(pluck(groups, 'name'), ['prior']);
  assert.deepEqual(rowsOf(groups[0].rows, 'label', 'verdict'), [
    ['Raw: Average precision, IoU 0.5', null],
    ['With prior: Average precision, IoU 0.5', null],
  ]);
  assert.equal(groups[0].of, '3 pictures.');
});

test('one sign is not called one signs', () => {
  const [group] = figureGroups({ corrections: { new: { ap50: 1, pictures: 13, signs: 1, crops: 1300 }, parent: {} } });
  assert.equal(group.of, '13 pictures, 1 sign, 1,300 crops.');
});

test('new figures are marked as new, and values that are not numbers are left out', () => {
  const [group] = figureGroups({ gtsdb: { new: { ap50: 1, text: 'x', odd: NaN, signs_right: 0.5 }, parent: { ap50: 1 } } });
  assert.deepEqual(rowsOf(group.rows, 'name', 'verdict'), [
    ['ap50', 'same'],
    ['signs_right', 'new'],
  ]);
});

test('complaints are the server’s sentences', () => {
  assert.deepEqual(regressions({ worse: ['A fell.'] }), ['A fell.']);
  assert.deepEqual(regressions({}), []);
});

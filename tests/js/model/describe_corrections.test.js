// @ts-check
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { NO_CLASS, emptyDoc } from '../../../static/js/model/documents.js';
import { labelName } from '../../../static/js/model/labels.js';
import { describeLabels } from '../../../static/js/model/describe_corrections.js';
import { labelsNamed } from '../labels.js';
import { keyFrame } from '../server_data.js';

const labels = labelsNamed(['speed limit 20 km/h', 'yield']);
/** @param {number} id */
const nameOf = (id) => labelName(labels, id);
const bare = emptyDoc({ track: 7, first: 0, last: 99 });
const key = keyFrame({ interpolate: false });

test('no word, not in the set and a number that no label has are distinguished', () => {
  assert.deepEqual(
    [null, NO_CLASS, 1, 40].map((id) => labelName(labels, id)),
    ['unlabelled', 'not in the set', 'yield', 'label 40'],
  );
});

test('labels of people are described beside the engine’s label', () => {
  assert.equal(describeLabels(undefined, 0, nameOf), null);
  assert.equal(describeLabels(bare, 0, nameOf), null);
  assert.equal(describeLabels({ ...bare, class_id: 1 }, 0, nameOf), 'Label set by a person; the engine reads speed limit 20 km/h.');
  assert.equal(describeLabels({ ...bare, class_id: 0 }, 0, nameOf), 'Label set by a person; the engine reads the same.');
  assert.equal(describeLabels({ ...bare, class_id: NO_CLASS }, null, nameOf), 'Label set by a person.');
});

test('boxes that are called otherwise than their track are named, a few of many', () => {
  const one = { ...bare, keys: { 5: { ...key, class_id: 1 }, 9: { ...key, class_id: 0 }, 12: key } };
  assert.equal(describeLabels(one, 0, nameOf), 'Single boxes have other labels: yield in frame 5.');
  const many = { ...bare, class_id: 0, keys: Object.fromEntries([1, 2, 3, 4, 5].map((frame) => [frame, { ...key, class_id: NO_CLASS }])) };
  assert.equal(
    describeLabels(many, 0, nameOf),
    'Label set by a person; the engine reads the same. Single boxes have other labels: ' +
      'not in the set in frame 1, not in the set in frame 2, not in the set in frame 3 and 2 more.',
  );
});

// @ts-check
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { blankDoc } from '../../../static/js/model/documents.js';
import { whyNoBox } from '../../../static/js/model/missing_box.js';

test('a track without a box in a frame is deleted, merged, or somewhere else', () => {
  assert.match(whyNoBox('m7', undefined), /no box in this frame\. K copies/);
  assert.match(whyNoBox('m7', blankDoc('m7')), /K copies/);
  assert.match(whyNoBox('m7', { ...blankDoc('m7'), gone: true }), /^Track #7 is deleted\. The list/);
  assert.match(whyNoBox('m7', { ...blankDoc('m7'), gone: true, merged_into: 'm2' }), /^Track #7 is now part of #2/);
});

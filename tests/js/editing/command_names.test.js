// @ts-check
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { describeUndone, withTrackNames } from '../../../static/js/editing/command_names.js';

test('what several tracks are about names none of them, what one is about names it', () => {
  assert.equal(describeUndone('import', 12, '#1', 9), 'import of 9 tracks');
  assert.equal(describeUndone('import', 12, '#1', 1), 'import of 1 track');
  assert.equal(describeUndone('import', 12), 'import');
  assert.equal(describeUndone('import_bundle', 12, '#1', 2), 'bug bundle opened');
  assert.equal(describeUndone('review_tracks', 12, '#1', 2), 'verdict on several tracks');
  assert.equal(describeUndone('adopt', 12, '#1', 1), 'track taken over, track #1');
  assert.equal(describeUndone('set_box', 12, '#1', 1), 'box corrected in frame 12');
});

test('sentences call tracks by their names', () => {
  assert.equal(
    withTrackNames('Track m2 has nothing on one side of frame 15. Split it in between.', {}),
    'Track #2 has nothing on one side of frame 15. Split it in between.',
  );
  assert.equal(withTrackNames('Frame 3 is no key frame of track h0123456789abcdef.', {}), 'Frame 3 is no key frame of track made by hand.');
  assert.equal(withTrackNames('A track has had enough.', {}), 'A track has had enough.');
});

// @ts-check
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { blankDoc, emptyDoc } from '../../../static/js/model/documents.js';
import { merge, mergeTracks, sharedFrames, describeSharedFrames } from '../../../static/js/operations/merge.js';
import { changeReview } from '../../../static/js/store/actions/review.js';
import { nearestFrame } from '../../../static/js/views/dialogs/merge.js';
import { createEditorFixture } from '../editing/editor_fixture.js';
import { syntheticRun } from '../harness/synthetic_run.js';
import { pluck } from '../pluck.js';
import { keyFrame } from '../server_data.js';

const KEY = keyFrame({ box: [10, 10, 30, 30] });
/** @param {string} key @param {number} first @param {number} last */
const track = (key, first, last) => ({ ...blankDoc(key), keys: { [first]: KEY, [last]: KEY } });
const docs = { ha: track('ha', 10, 20), hb: track('hb', 19, 30), hc: track('hc', 31, 40), hd: track('hd', 20, 22) };
const review = /** @type {any} */ ({ tracks: null, docs });

test('tracks that are seen at once share frames, also with what was added before', () => {
  assert.deepEqual(sharedFrames(review, 'ha', ['hc']), []);
  assert.deepEqual(sharedFrames(review, 'ha', ['hc', 'hb', 'hd']), [
    { key: 'hb', stays: ['ha'], runs: [[19, 20]] },
    {
      key: 'hd',
      stays: ['ha', 'hb'],
      runs: [
        [20, 20],
        [21, 22],
      ],
    },
  ]);
  assert.deepEqual(pluck(sharedFrames(review, 'hc', ['ha', 'hd']), 'stays'), [['ha']], 'two that were added, not the first one');
});

test('the words say how many frames, which, and whose box stays', () => {
  const [one, several] = sharedFrames(review, 'ha', ['hb', 'hd']).map((shared) => describeSharedFrames(review, shared));
  assert.equal(
    one,
    'Tracks drawn at 10 and drawn at 19 have boxes in 2 common frames (19–20). One frame of a track has one box: the box of drawn at 10 stays, and the box of drawn at 19 is removed.',
  );
  assert.match(
    several,
    /^Tracks drawn at 10, drawn at 19 and drawn at 20 have boxes in 3 common frames \(20–22\)\. .*the box of the track marked first stays/,
  );
});

test('a merge of tracks that share frames asks first and changes nothing yet; another is done at once', async () => {
  const { store, editor, review: now, end } = await createEditorFixture();
  const app = { store, edit: editor.edit };
  const tracks = { ...syntheticRun(200, 2).tracks, id: [1, 2], first: [0, 50], last: [99, 150] };
  store.dispatch(changeReview, { tracks });
  editor.edit({ name: 'split', key: 'm1', frame: 50, new_key: 'hlater', class_id: 14 });
  store.dispatch(changeReview, { mode: 'merge', marked: ['m1', 'hlater'] });
  merge(app, () => {});
  await editor.settled();
  assert.equal(now().docs.hlater.merged_into, 'm1');
  assert.deepEqual([now().selected, now().mode, store.get().dialog], ['m1', 'select', null]);
  editor.edit({ name: 'create_track', key: 'hother', frame: 20, box: [1, 1, 9, 9], class_id: 14 });
  await editor.settled();
  store.dispatch(changeReview, { mode: 'merge', marked: ['m1', 'hother'] });
  merge(app, () => {});
  assert.deepEqual(store.get().dialog, { kind: 'merge', data: { marked: ['m1', 'hother'] } });
  assert.equal(now().docs.hother.gone, false);
  end();
});

test('a part of an engine track keeps its label when an earlier track is merged into it', async () => {
  const { store, editor, review: now, end } = await createEditorFixture();
  const tracks = { ...syntheticRun(200, 2).tracks, id: [1, 2], first: [0, 50], last: [99, 150], class_id: [14, 38] };
  store.dispatch(changeReview, { tracks });
  editor.edit({ name: 'split', key: 'm2', frame: 100, new_key: 'hlater', class_id: 38 });
  store.dispatch(changeReview, { mode: 'merge', marked: ['hlater', 'm1'] });
  merge({ store, edit: editor.edit }, () => {});
  await editor.settled();
  const { segments, class_id } = now().docs.hlater;
  assert.deepEqual([pluck(segments, 'track'), class_id], [[1, 2], 38]);
  end();
});

test('what is shown is the common frame nearest to the cursor', () => {
  assert.deepEqual(
    [0, 12, 18, 99].map((frame) =>
      nearestFrame(
        [
          [10, 14],
          [20, 30],
        ],
        frame,
      ),
    ),
    [10, 12, 20, 30],
  );
});

test('a merge during a run keeps the boxes after the end of a track', async () => {
  const { store, editor, review: now, end } = await createEditorFixture();
  const tracks = { ...syntheticRun(200, 2).tracks, id: [1, 2], first: [0, 50], last: [20, 150] };
  const lanes = { track: [1, 2], first: [0, 50], last: [20, 150], source: [0, 0] };
  const run = /** @type {any} */ ({ ...now().run, state: 'running' });
  store.dispatch(changeReview, { tracks, lanes, run });
  assert.ok(mergeTracks({ store, edit: editor.edit }, 'm1', ['m2']));
  assert.deepEqual(now().docs.m1.segments, [
    { track: 1, first: 0, last: 49 },
    emptyDoc({ track: 2, first: 50, last: 150 }, true).segments[0],
  ]);
  end();
});

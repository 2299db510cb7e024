// @ts-check
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { boxes } from '../../../static/js/operations/boxes.js';
import { interpolate, setKeyFrame, setMissingKeyFrame } from '../../../static/js/operations/key_frames.js';
import { createTrack, handleDrawnBox } from '../../../static/js/operations/place_box.js';
import { closeDialog } from '../../../static/js/store/actions/page.js';
import { askForClass, changeReview, draftOf, setMode } from '../../../static/js/store/actions/review.js';
import { createEditorFixture } from '../editing/editor_fixture.js';

/** @typedef {import('../../../static/js/types.js').Box} Box */

/** @type {Box} */
const BOX = [10, 20, 40, 60];
/** No track is followed. @type {any} */
const NOTHING = {};

test('a drawn box waits in the dialog; closing the dialog leaves nothing behind', async () => {
  const { store, editor, server, review, end } = await createEditorFixture();
  store.dispatch(setMode, 'draw');
  const before = review();
  handleDrawnBox({ store, edit: editor.edit, following: NOTHING }, BOX, false);
  const draft = draftOf(store.get());
  assert.deepEqual([draft?.box, draft?.frame, draft?.key[0]], [BOX, 0, 'h']);
  assert.equal(review().mode, 'select');
  store.dispatch(closeDialog);
  await editor.settled();
  assert.equal(draftOf(store.get()), null);
  assert.deepEqual([review().docs, review().unsaved, review().selected], [before.docs, [], before.selected]);
  assert.deepEqual(server.log, []);
  end();
});

test('with its class it is one edit, so that one undo takes it back', async () => {
  const { store, editor, server, review, end } = await createEditorFixture();
  handleDrawnBox({ store, edit: editor.edit, following: NOTHING }, BOX, false);
  const draft = draftOf(store.get());
  assert.ok(draft);
  createTrack({ store, edit: editor.edit }, draft, 14);
  await editor.settled();
  assert.deepEqual(server.log, ['create_track']);
  assert.equal(review().selected, draft.key);
  assert.equal(review().docs[draft.key].class_id, 14);
  assert.deepEqual(review().docs[draft.key].keys[0].box, BOX);
  end();
});

test('with Shift the box corrects the selected track, and no class is asked for', async () => {
  const { store, editor, server, review, end } = await createEditorFixture();
  store.dispatch(changeReview, { selected: 'm1', mode: 'draw' });
  handleDrawnBox({ store, edit: editor.edit, following: NOTHING }, BOX, true);
  await editor.settled();
  assert.deepEqual([server.log, draftOf(store.get()), review().mode], [['set_box'], null, 'select']);
  end();
});

test('after a split the later half is selected, which has the box at the cursor; undone, the whole track is', async () => {
  const { store, editor, review, end } = await createEditorFixture();
  const split = boxes.find(({ id }) => id === 'split');
  store.dispatch(changeReview, { selected: 'm1', frame: 40 });
  split?.run(/** @type {any} */ ({ store, edit: editor.edit }));
  await editor.settled();
  const later = review().selected ?? '';
  assert.notEqual(later, 'm1');
  assert.deepEqual(
    [review().docs.m1.segments, review().docs[later].segments],
    [[{ track: 1, first: 0, last: 39 }], [{ track: 1, first: 40, last: 99 }]],
  );
  await editor.undo();
  assert.equal(review().selected, 'm1');
  end();
});

test('a split behind the last frame of the engine hands on the class that was shown', async () => {
  const { store, editor, review, end } = await createEditorFixture();
  const split = boxes.find(({ id }) => id === 'split');
  store.dispatch(changeReview, { selected: 'm1', frame: 120 });
  editor.edit({ name: 'set_box', key: 'm1', frame: 120, box: BOX });
  split?.run(/** @type {any} */ ({ store, edit: editor.edit }));
  const later = review().selected ?? '';
  assert.deepEqual([review().docs[later].segments, review().docs[later].class_id, review().docs.m1.class_id], [[], 14, null]);
  end();
});

test('asking for a class changes no document', () => {
  const state = /** @type {any} */ ({ review: { mode: 'draw', docs: {}, marked: [], drag: null }, dialog: null });
  const asked = askForClass(state, { key: 'h1', frame: 3, box: BOX });
  assert.equal(asked.review?.docs, state.review.docs);
  assert.equal(draftOf({ ...asked, dialog: { kind: 'relabel', data: { key: 'm1' } } }), null);
});

for (const [id, what] of /** @type {const} */ ([
  ['occluded', 'occluded'],
  ['outside', 'outside'],
])) {
  test(`a box of the engine stays the engine's when it is marked ${what}; one on a line of people's is pinned`, async () => {
    const { store, editor, review, end } = await createEditorFixture();
    const mark = boxes.find((one) => one.id === id);
    const app = /** @type {any} */ ({ store, edit: editor.edit });
    const track = /** @type {any} */ ({ id: 1, state: 'confirmed', source: 0, box: BOX, class_id: 14 });
    const overlays = Object.fromEntries([40, 45, 50].map((frame) => [frame, { frame, detections: [], tracks: [track] }]));
    store.dispatch((state) =>
      changeReview(state, {
        selected: 'm1',
        frame: 40,
        tracks: state.review?.tracks && { ...state.review.tracks, class_id: [14, 14] },
        overlays: /** @type {any} */ (overlays),
      }),
    );
    mark?.run(app);
    await editor.settled();
    assert.deepEqual(review().docs.m1.keys[40].box, null);
    assert.equal(review().docs.m1.keys[40][what], true);
    mark?.run(app);
    for (const frame of [45, 55]) editor.edit({ name: 'set_box', key: 'm1', frame, box: BOX });
    editor.edit({ name: 'interpolate', key: 'm1', frame: 45, first: 45, last: 55, value: true });
    store.dispatch(changeReview, { frame: 50 });
    mark?.run(app);
    await editor.settled();
    assert.deepEqual(review().docs.m1.keys[50].box, BOX);
    end();
  });
}

test('behind a track’s end there is nothing to delete and nothing to take out of sight: it is refused, and nothing is to be undone', async () => {
  const { store, editor, server, toasts, review, end } = await createEditorFixture();
  store.dispatch((state) =>
    changeReview(state, { selected: 'm1', frame: 120, tracks: state.review?.tracks && { ...state.review.tracks, class_id: [14, 14] } }),
  );
  for (const id of ['delete-from', 'outside', 'split'])
    boxes.find((one) => one.id === id)?.run(/** @type {any} */ ({ store, edit: editor.edit }));
  await editor.settled();
  assert.deepEqual([server.log, review().unsaved, review().docs], [[], [], {}]);
  assert.deepEqual(toasts.slice(0, 2), [
    'Track #1 shows nothing from frame 120 on. There is nothing to delete.',
    'Track #1 shows nothing from frame 120 on. It is outside already.',
  ]);
  assert.match(toasts[2], /nothing on one side of frame 120/);
  end();
});

test('I says which way it went: a drawn track has its lines from the beginning', async () => {
  const { store, editor, review, end } = await createEditorFixture();
  /** @type {string[]} */
  const messages = [];
  const app = { store, edit: editor.edit, following: NOTHING };
  const say = (/** @type {string} */ text) => void messages.push(text);
  const press = () => interpolate(app, say);
  createTrack(app, { key: 'h1', frame: 0, box: BOX }, 14);
  store.dispatch(changeReview, { selected: 'h1', frame: 20 });
  press();
  assert.deepEqual(messages, [], 'one key frame has nothing to lie between');
  handleDrawnBox(app, [20, 20, 50, 60], true, say);
  press();
  press();
  await editor.settled();
  assert.equal(review().docs.h1.keys[0].interpolate, true);
  const line = 'In 19 frames (1–19) the box is interpolated between key frames; nobody saw the sign there.';
  assert.deepEqual(messages, [
    line,
    'There are no boxes any more between frames 0 and 20; press I again to interpolate.',
    `Boxes are interpolated between frames 0 and 20. ${line}`,
  ]);
  end();
});

test('a key frame out of the track’s frames says which box it copied; within them nothing is to be told', async () => {
  const { store, editor, review, end } = await createEditorFixture();
  /** @type {[string, any][]} */
  const messages = [];
  const app = { store, edit: editor.edit };
  const say = (/** @type {string} */ text, /** @type {any} */ options) => void messages.push([text, options]);
  editor.edit({ name: 'set_box', key: 'm1', frame: 98, box: BOX });
  store.dispatch(changeReview, { selected: 'm1', frame: 120 });
  setKeyFrame(app, say);
  await editor.settled();
  assert.deepEqual(review().docs.m1.keys[120].box, BOX);
  assert.equal(messages[0][0], 'Track #1 had no box in frame 120: the box of frame 98 was copied here. Move it onto the sign.');
  assert.equal(messages[0][1].action.label, 'Undo');
  setKeyFrame(app, say);
  await editor.settled();
  assert.equal(messages.length, 1, 'taken back');
  end();
});

test('a line that lacks a key frame offers to set one, here or at the other end of the track', async () => {
  const { store, editor, review, end } = await createEditorFixture();
  const app = /** @type {any} */ ({ store, edit: editor.edit });
  const line = boxes.find(({ id }) => id === 'interpolate');
  const tracks = /** @type {any} */ ({ ...review().tracks, class_id: [14, 14] });
  const overlays = Object.fromEntries(
    [40, 99].map((frame) => [frame, { frame, detections: [], tracks: [{ id: 1, state: 'confirmed', source: 0, box: BOX, class_id: 14 }] }]),
  );
  store.dispatch(changeReview, { tracks, selected: 'm1', frame: 40, overlays: /** @type {any} */ (overlays) });
  assert.equal(line?.disabled(store.get()), 'Needs a key frame before and after. Set one at frame 40?');
  const remedy = line?.remedy?.(app);
  assert.equal(remedy?.label, 'Set key frame');
  remedy?.run();
  assert.deepEqual(review().docs.m1.keys[40].box, BOX);
  assert.equal(line?.disabled(store.get()), 'Needs a key frame before and after. Set one at frame 99?');
  setMissingKeyFrame(app, () => {});
  await editor.settled();
  assert.equal(review().frame, 99);
  assert.deepEqual(Object.keys(review().docs.m1.keys), ['40', '99']);
  assert.equal(line?.disabled(store.get()), null);
  end();
});

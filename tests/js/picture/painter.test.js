// @ts-check
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { placeLabels } from '../../../static/js/model/label_layout.js';
import { changeReview, openReview, toggleLayer } from '../../../static/js/store/actions/review.js';
import { initialState } from '../../../static/js/store/initial.js';
import { paintLayers } from '../../../static/js/views/picture/painter.js';
import { fakeContext } from '../canvas.js';
import { overlayTrack } from '../server_data.js';

const BOX = [100, 100, 200, 200];
/** A selected track whose prediction, search and second-best window lie within its box. */
function createState() {
  const track = overlayTrack({
    source: 2,
    box: BOX,
    gate: { l_positive: 4.93, confident: true },
    prediction: { box: [110, 110, 190, 190], sigma: [10, 10, 1, 1] },
    relocalisation: { box: [120, 120, 180, 180], search: [105, 105, 195, 195], runner_up: [130, 130, 150, 150], decision: 1 },
  });
  const state = openReview(initialState(), /** @type {any} */ ({ id: 'v', width: 640, height: 360, frames: 10 }));
  return changeReview(
    state,
    /** @type {any} */ ({
      shown: 0,
      overlays: { 0: { frame: 0, detections: [], tracks: [track] } },
      viewport: { zoom: 1, x: 320, y: 180 },
      selected: 'm1',
    }),
  );
}

/** The drawing calls, in order. @param {import('../../../static/js/state-types.js').State} state */
function drawingCalls(state) {
  /** @type {{name: string, args: any[]}[]} */
  const calls = [];
  const ctx = fakeContext((name, args) => calls.push({ name, args }), 60);
  const inks = { colour: () => '#fff', casing: '#000', font: '12px sans', unit: 1 };
  paintLayers(ctx, /** @type {any} */ (state.review), { zoom: 1, x: 320, y: 180 }, { width: 640, height: 360 }, inks, () => 'stop');
  return calls;
}

/** Corners of a rectangle. @param {{args: any[]}} call */
const corners = ({ args: [x, y, wide, high] }) => [x, y, x + wide, y + high];

test('only outline and handles cover the sign in the selected box', () => {
  const calls = drawingCalls(createState());
  const cleared = calls.findIndex(({ name }) => name === 'clearRect');
  assert.deepEqual(corners(calls[cleared]), BOX);
  const after = calls
    .slice(cleared + 1)
    .filter(({ name }) => name === 'rect')
    .map(corners);
  assert.deepEqual(after, [BOX, BOX], 'casing and line of the box itself');
  assert.ok(
    calls.slice(0, cleared).some((call) => call.name === 'rect' && corners(call)[0] === 110),
    'the prediction stays visible outside the box',
  );
  assert.ok(
    calls.some(({ name, args }) => name === 'fillText' && args[0] === 'stop'),
    'without its gate value',
  );
});

test('the uncertainty box and the gate value are drawn when their layers are on', () => {
  const state = toggleLayer(toggleLayer(createState(), 'uncertainty'), 'gate');
  const calls = drawingCalls(state);
  const cleared = calls.findIndex(({ name }) => name === 'clearRect');
  assert.ok(calls.slice(cleared).some((call) => call.name === 'rect' && String(corners(call)) === '140,140,160,160'));
  assert.ok(calls.some(({ name, args }) => name === 'fillText' && args[0] === 'stop gate 4.9'));
});

test('a label moves away instead of covering a guarded box', () => {
  const guarded = /** @type {const} */ ({ box: [100, 100, 200, 140], wide: 60, high: 16, where: 'above', guarded: true });
  const small = /** @type {const} */ ({ box: [110, 142, 120, 152], wide: 60, high: 16, where: 'above' });
  const [, place] = placeLabels(/** @type {any} */ ([guarded, small]), { width: 640, height: 360 });
  assert.ok(place);
  const over = Math.min(200, place.x + 60) > Math.max(100, place.x) && Math.min(140, place.y + 16) > Math.max(100, place.y);
  assert.equal(over, false);
});

// @ts-check
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { blankDoc, emptyDoc } from '../../../static/js/model/documents.js';
import { covers, rangeAround, recordingFor, storedFrames } from '../../../static/js/views/recording/ranges.js';
import { readMessage } from '../../../static/js/views/recording/messages.js';
import { seekRequest, selectRequest } from '../../../static/js/views/recording/protocol.js';
import { createTimeSync } from '../../../static/js/views/recording/time_sync.js';
import { correctedKeysInOrder, entityOf, trackOf } from '../../../static/js/views/recording/selection.js';
import { keyFrame } from '../server_data.js';

/** @param {Uint8Array} data */
const hex = (data) => Buffer.from(data).toString('hex');
/** @param {number} id @param {object} [more] */
const track = (id, more = {}) => /** @type {any} */ ({ id, prediction: null, relocalisation: null, ...more });
/** @type {import('../../../static/js/types.js').Overlay} */
const OVERLAY = {
  frame: 4,
  detections: /** @type {any} */ ([{ track: null }, { track: 9 }]),
  tracks: [track(9, { prediction: {} }), track(7, { prediction: {}, relocalisation: {} }), track(8)],
};
/** @param {string} id @param {number} first @param {number} stop @param {string} [state] */
const recording = (id, first, stop, state = 'complete') => /** @type {any} */ ({ id, state, options: { first, stop } });

test('a seek request has the bytes that the viewer expects', () => {
  // set_time_cursor { timeline { name: "frame" } time { time: 300 } play_state: PAUSED }
  assert.equal(hex(seekRequest('frame', 300)), '3210' + '12070a056672616d65' + '1a0308ac02' + '2801');
  assert.equal(hex(seekRequest('frame', 0)), '320f' + '12070a056672616d65' + '1a020800' + '2801');
  assert.equal(hex(seekRequest('frame', 2 ** 40)).slice(-18), '08808080808020' + '2801');
});

test('a selection is a link within the recording', () => {
  const data = selectRequest('video/results[#1]');
  assert.equal(hex(data.subarray(0, 4)), '221f0a1d');
  assert.equal(new TextDecoder().decode(data.subarray(4)), 'recording://video/results[#1]');
});

test('a corrected or drawn box maps to its track if the recording has the same corrections', () => {
  assert.equal(trackOf('/video/corrected', 1, OVERLAY, ['m7', 'hab']), 'hab');
  assert.equal(trackOf('/video/corrected', 1, undefined, ['m7', 'hab']), 'hab');
  assert.equal(trackOf('/video/corrected', 2, OVERLAY, ['m7', 'hab']), null);
  assert.equal(trackOf('/video/corrected', 0, OVERLAY), null, 'edited since');
});

test('corrected keys are in the order of the recording: by number, then drawn ones, without false positives', () => {
  const box = /** @type {import('../../../static/js/types.js').Box} */ ([0, 0, 9, 9]);
  const key = keyFrame({ box, class_id: 1 });
  const drawnDoc = (/** @type {string} */ name) => ({ ...blankDoc(name), class_id: 1, keys: { 3: key } });
  const track = (/** @type {number} */ id) => ({ id, box, state: 'confirmed', class_id: 1, prediction: null, relocalisation: null });
  const engineDoc = (/** @type {number} */ id) => emptyDoc({ track: id, first: 0, last: 9 });
  const docs = {
    hb: drawnDoc('hb'),
    ha: drawnDoc('ha'),
    m10: { ...engineDoc(10), review: 'accepted' },
    m4: { ...engineDoc(4), review: 'rejected' },
    m5: { ...engineDoc(5), not_a_sign: true },
  };
  const review = /** @type {any} */ ({
    frame: 3,
    docs,
    tracks: null,
    overlays: { 3: { tracks: [track(10), track(4), track(9), track(5)], detections: [] } },
  });
  assert.deepEqual(correctedKeysInOrder(review), ['m9', 'm10', 'ha', 'hb']);
});

test('a selection in the viewer maps to its track', () => {
  assert.equal(trackOf('/tracks/m7/gate/l_positive', null, undefined), 'm7');
  assert.equal(trackOf('/tracks/other', null, OVERLAY), null);
  assert.equal(trackOf('/video/results', 0, OVERLAY), 'm9');
  assert.equal(trackOf('/video/results', 2, OVERLAY), 'm8');
  assert.equal(trackOf('/video/results', 3, OVERLAY), null);
  assert.equal(trackOf('/video/predictions', 0, OVERLAY), 'm7', 'predictions are sorted by track');
  assert.equal(trackOf('/video/innovation', 1, OVERLAY), 'm9');
  assert.equal(trackOf('/video/search', 0, OVERLAY), 'm7');
  assert.equal(trackOf('/video/detections', 0, OVERLAY), null, 'a detection without a track');
  assert.equal(trackOf('/video/detections_raw', 1, OVERLAY), 'm9');
  assert.equal(trackOf('/video/truth', 0, OVERLAY), null);
  assert.equal(trackOf('/video/results', null, OVERLAY), null, 'the whole layer is no track');
  assert.equal(trackOf(null, null, OVERLAY), null);
});

test('a track maps to its box, else to its states', () => {
  assert.equal(entityOf('m7', OVERLAY), 'video/results[#1]');
  assert.equal(entityOf('m70', OVERLAY), 'tracks/m70/state');
  assert.equal(entityOf('m7', undefined), 'tracks/m7/state');
  assert.equal(entityOf('h3f2a9c', OVERLAY), null);
  for (const { id } of OVERLAY.tracks) {
    const [, place] = /\[#(\d+)\]$/.exec(entityOf(`m${id}`, OVERLAY) ?? '') ?? [];
    assert.equal(trackOf('/video/results', Number(place), OVERLAY), `m${id}`);
  }
});

test('a new recording surrounds the cursor, within the run', () => {
  assert.deepEqual(rangeAround(500, { first: 0, stop: 1000 }), { first: 350, stop: 650 });
  assert.deepEqual(rangeAround(20, { first: 0, stop: 1000 }), { first: 0, stop: 300 });
  assert.deepEqual(rangeAround(990, { first: 0, stop: 1000 }), { first: 700, stop: 1000 });
  assert.deepEqual(rangeAround(120, { first: 100, stop: 150 }), { first: 100, stop: 150 });
  assert.equal(rangeAround(0, { first: 5, stop: 5 }), null);
  for (let frame = 0; frame < 400; frame += 7) assert.ok(covers(/** @type {any} */ (rangeAround(frame, { first: 0, stop: 400 })), frame));
  assert.deepEqual(storedFrames(/** @type {any} */ ({ first: 10, frames_done: 5 })), { first: 10, stop: 15 });
});

test('the newest finished recording that has the frame is shown', () => {
  const list = [recording('a', 0, 50, 'failed'), recording('b', 40, 90, 'running'), recording('c', 30, 60), recording('d', 0, 60)];
  assert.equal(recordingFor(list, 45)?.id, 'c');
  assert.equal(recordingFor(list, 10)?.id, 'd');
  assert.equal(recordingFor(list, 60), null);
});

test('messages of other types are ignored', () => {
  for (const data of [null, 'time', 7, {}, { type: 'else' }, { kind: 'time' }]) assert.equal(readMessage(data, ['time']), null);
  assert.deepEqual(readMessage({ type: 'time', frame: 3 }, ['time']), { type: 'time', frame: 3 });
});

test('the page hears only of the frames to which a person moves the viewer', () => {
  const sync = createTimeSync();
  assert.equal(sync.report(0), null, 'the first frame of a recording is nobody’s choice');
  assert.ok(sync.request(84));
  assert.equal(sync.report(0), null);
  assert.equal(sync.report(84), null);
  assert.ok(!sync.request(84), 'it is there');
  assert.equal(sync.report(85), 85);
  assert.ok(sync.request(10));
  assert.ok(sync.request(11));
  assert.equal(sync.report(11), null);
  assert.equal(sync.report(10), 10, 'the request for 10 was overtaken');
});

test('a viewer that opens only after a request of the page does not take the page back', () => {
  const sync = createTimeSync();
  assert.ok(sync.request(84));
  assert.ok(!sync.hasTime());
  assert.equal(sync.report(0), null);
  assert.ok(sync.hasTime() && sync.isNewest(84));
  assert.equal(sync.report(84), null);
  sync.reset(); // another recording
  assert.equal(sync.report(40), null);
  assert.equal(sync.report(41), 41);
});

test('a viewer that refuses a request can be asked for the same frame again', () => {
  const sync = createTimeSync();
  sync.report(0);
  sync.request(84);
  sync.giveUp();
  assert.ok(!sync.isNewest(84));
  assert.equal(sync.report(0), null);
  assert.ok(sync.request(84));
});

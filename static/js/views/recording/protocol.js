// @ts-check
/**
 * The part of the viewer's control protocol that the page uses: protocol buffers, written by hand.
 *
 * Messages of `rerun.viewer_control.v1alpha1` as in SDK 0.41. The protocol is not public, so the SDK's version is
 * pinned, and `tests/app/recordings/test_protocol.py` compares the numbers below with the descriptor in the SDK.
 */

/** Field numbers, as in the descriptor: message -> field -> number. */
export const FIELDS = Object.freeze({
  ViewerControlRequest: Object.freeze({ open: 4, set_time_cursor: 6 }),
  SetTimeCursorRequest: Object.freeze({ timeline: 2, time: 3, play_state: 5 }),
  OpenRequest: Object.freeze({ url: 1 }),
  Timeline: Object.freeze({ name: 1 }),
  TimelineTime: Object.freeze({ time: 1 }),
});
/** `PLAY_STATE_PAUSED` */
export const PAUSED = 1;

const LENGTH_DELIMITED = 2;

/**
 * Move the time cursor, and stop there.
 *
 * @param {string} timeline
 * @param {number} time   an ordinal >= 0
 * @returns {Uint8Array<ArrayBuffer>}   a `ViewerControlRequest`
 */
export function seekRequest(timeline, time) {
  const cursor = FIELDS.SetTimeCursorRequest;
  return bytes(FIELDS.ViewerControlRequest.set_time_cursor, [
    ...text(cursor.timeline, text(FIELDS.Timeline.name, timeline)),
    ...text(cursor.time, number(FIELDS.TimelineTime.time, time)),
    ...number(cursor.play_state, PAUSED),
  ]);
}

/**
 * Select an entity of the shown recording.
 *
 * @param {string} entity   its path, without a leading slash
 * @returns {Uint8Array<ArrayBuffer>}   a `ViewerControlRequest`
 */
export function selectRequest(entity) {
  return bytes(FIELDS.ViewerControlRequest.open, text(FIELDS.OpenRequest.url, `recording://${entity}`));
}

/** @param {number} field @param {number[]} content @returns {Uint8Array<ArrayBuffer>} */
const bytes = (field, content) => Uint8Array.from(text(field, content));

/** @param {number} field @param {string|number[]} content @returns {number[]}   a field with a length: text or message */
function text(field, content) {
  const data = typeof content === 'string' ? [...new TextEncoder().encode(content)] : content;
  return [...varint(field * 8 + LENGTH_DELIMITED), ...varint(data.length), ...data];
}

/** @param {number} field @param {number} value   a whole number >= 0 @returns {number[]} */
const number = (field, value) => [...varint(field * 8), ...varint(value)];

/** @param {number} value @returns {number[]} */
function varint(value) {
  const out = [];
  let rest = BigInt(value);
  while (rest > 127n) {
    out.push(Number(rest & 127n) | 128);
    rest >>= 7n;
  }
  return [...out, Number(rest)];
}

// @ts-check
/**
 * The lane of a track as people have left it: that of the engine's track, a part of it after a split, several parts
 * after a merge. Pure.
 *
 * Votes of a part are counted anew from its own frames (Eq. 4: the sum of w P over the sum of w), for the engine's include
 * frames that are not the track's any more.
 *
 * @typedef {import('../types.js').TrackLane} TrackLane
 * @typedef {import('../types.js').TrackDoc} TrackDoc
 * @typedef {import('./plain_words.js').Sentence} Sentence
 * @typedef {{lane: TrackLane, from: number, to: number}} Piece   places in the columns of an engine's lane, `to` excluded
 *
 * @typedef {object} DocumentLane
 * @property {TrackLane} lane          its `id` is that of the first piece
 * @property {readonly number[]} track the engine's track behind each entry
 * @property {boolean} whole           nobody has cut it or joined it
 * @property {readonly Piece[]} pieces in order of time
 * @property {Reading|null} reading    what its frames are read as together; null: none of them voted
 *
 * @typedef {object} Reading
 * @property {number} class_id
 * @property {number} share
 * @property {number|null} runner_up
 * @property {number} runner_up_share  0 without a runner-up
 */
import { sentencesOf } from './plain_words.js';
import { trackName } from './track_name.js';

/** Classes whose votes are told, as in the engine's lanes. */
const LEADING = 6;
/** What of a lane is no column with an entry a frame. @type {ReadonlySet<keyof TrackLane>} */
const NOT_BY_FRAME = new Set(/** @type {const} */ (['id', 'tau', 'classes', 'events', 'votes', 'probabilities']));

/** What was asked for last: lanes and inspector ask for the same. @type {{key: string, segments: readonly unknown[]|null, lanes: readonly TrackLane[], found: DocumentLane|null}|null} */
let latest = null;

/**
 * The lane of a track.
 *
 * @param {string} key
 * @param {TrackDoc|undefined} doc            undefined: nobody has touched it
 * @param {Record<number, TrackLane>} lanes   those that are loaded, by the engine's track
 * @returns {DocumentLane|null} null: nothing of it is loaded, or a person drew it; the same object for the same lanes
 */
export function documentLane(key, doc, lanes) {
  const segments = doc?.segments ?? null;
  const tracks = segments ? segments.map(({ track }) => track) : key.startsWith('m') ? [Number(key.slice(1))] : [];
  const loaded = tracks.map((track) => lanes[track]).filter((lane) => lane !== undefined);
  const known = latest?.key === key && latest.segments === segments && latest.lanes.length === loaded.length && latest.lanes.every((lane, i) => lane === loaded[i]);
  if (!latest || !known) latest = { key, segments, lanes: loaded, found: joined(segments ? piecesOf(segments, lanes) : loaded.map((lane) => ({ lane, from: 0, to: lane.frame.length }))) };
  return latest.found;
}

/**
 * What happened to a track, in order of frames: events of its pieces, and where they were cut and joined.
 *
 * @param {DocumentLane} found
 * @returns {Sentence[]}
 */
export function sentencesOfTrack({ pieces, whole }) {
  if (whole) return sentencesOf(pieces[0].lane);
  return pieces.flatMap(({ lane, from, to }) => {
    const [first, last] = [lane.frame[from], lane.frame[to - 1]];
    const own = sentencesOf(lane).filter(({ frame }) => first <= frame && frame <= last);
    const name = trackName(`m${lane.id}`);
    if (from > 0 || pieces.length > 1) own.unshift({ frame: first, kind: 'joined', text: `from here on it is the engine’s track ${name}` });
    if (to < lane.frame.length) own.push({ frame: last, kind: 'cut', text: `the engine’s track ${name} goes on, but no longer in this track` });
    return own;
  });
}

/**
 * @param {readonly import('../types.js').Segment[]} segments
 * @param {Record<number, TrackLane>} lanes
 * @returns {Piece[]}
 */
function piecesOf(segments, lanes) {
  const found = [];
  for (const { track, first, last } of segments) {
    const lane = lanes[track];
    if (!lane) continue;
    let from = 0;
    while (from < lane.frame.length && lane.frame[from] < first) from += 1;
    let to = from;
    while (to < lane.frame.length && lane.frame[to] <= last) to += 1;
    if (from < to) found.push({ lane, from, to });
  }
  return found.sort((a, b) => a.lane.frame[a.from] - b.lane.frame[b.from]);
}

/** @param {Piece[]} pieces @returns {DocumentLane|null} */
function joined(pieces) {
  if (pieces.length === 0) return null;
  const [{ lane, from, to }] = pieces;
  const whole = pieces.length === 1 && from === 0 && to === lane.frame.length;
  const track = pieces.flatMap((piece) => new Array(piece.to - piece.from).fill(piece.lane.id));
  const all = whole ? lane : voted(pieces);
  return { lane: all, track, whole, pieces, reading: readingOf(all) };
}

/** @param {Piece[]} pieces @returns {TrackLane} */
function voted(pieces) {
  const { classes, votes } = fuse(pieces);
  /** @param {Piece} piece @param {number} i */
  const probabilities = ({ lane }, i) => {
    const seen = lane.probabilities[i];
    return seen && classes.map((id) => seen[lane.classes.indexOf(id)] ?? 0);
  };
  /** @param {keyof TrackLane} name */
  const column = (name) => pieces.flatMap(({ lane, from, to }) => /** @type {unknown[]} */ (lane[name]).slice(from, to));
  const columns = /** @type {(keyof TrackLane)[]} */ (Object.keys(pieces[0].lane)).filter((name) => !NOT_BY_FRAME.has(name));
  return /** @type {TrackLane} */ ({
    .../** @type {object} */ (Object.fromEntries(columns.map((name) => [name, column(name)]))),
    id: pieces[0].lane.id, tau: pieces[0].lane.tau, classes, votes,
    probabilities: pieces.flatMap((piece) => piece.lane.frame.slice(piece.from, piece.to).map((_, k) => probabilities(piece, piece.from + k))),
    events: pieces.flatMap(({ lane, from, to }) => lane.events.filter(({ frame }) => lane.frame[from] <= frame && frame <= lane.frame[to - 1])),
  });
}

/**
 * Votes so far in each entry, for the classes that lead at the end.
 *
 * @param {Piece[]} pieces
 * @returns {{classes: number[], votes: (number[]|null)[]}}
 */
function fuse(pieces) {
  /** @type {Map<number, number>} */
  const sums = new Map();
  let weights = 0;
  /** @type {(Map<number, number>|null)[]} */
  const states = [];
  for (const { lane, from, to } of pieces) {
    for (let i = from; i < to; i += 1) {
      const seen = lane.probabilities[i];
      const weight = lane.weight[i];
      if (seen === null || weight === null) {
        states.push(null);
        continue;
      }
      weights += weight;
      lane.classes.forEach((id, c) => sums.set(id, (sums.get(id) ?? 0) + weight * seen[c]));
      states.push(new Map([...sums].map(([id, sum]) => [id, sum / weights])));
    }
  }
  const classes = [...sums].filter(([, sum]) => sum > 0).sort((a, b) => b[1] - a[1] || a[0] - b[0]).slice(0, LEADING).map(([id]) => id);
  return { classes, votes: states.map((state) => state && classes.map((id) => state.get(id) ?? 0)) };
}

/** @param {TrackLane} lane @returns {Reading|null} */
function readingOf(lane) {
  const last = lane.votes.filter((votes) => votes !== null).at(-1);
  if (!last || lane.classes.length === 0) return null;
  return { class_id: lane.classes[0], share: last[0], runner_up: lane.classes[1] ?? null, runner_up_share: last[1] ?? 0 };
}

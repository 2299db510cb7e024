// @ts-check
/**
 * The lane of a track with people's corrections: the lane of the engine's track, a part of it after a split, several
 * parts after a merge. Pure.
 *
 * The votes of a part are summed again over its own frames (Eq. 4: the sum of w P over the sum of w), because the
 * engine's sums include frames outside the part.
 *
 * @typedef {import('../types.js').TrackLane} TrackLane
 * @typedef {import('../types.js').TrackDoc} TrackDoc
 * @typedef {import('./describe_events.js').Sentence} Sentence
 * @typedef {{lane: TrackLane, from: number, to: number}} Piece   indices in the columns of an engine's lane, `to` exclusive
 *
 * @typedef {object} DocumentLane
 * @property {TrackLane} lane          its `id` is the first piece's
 * @property {readonly number[]} track the engine's track behind each entry
 * @property {boolean} whole           neither split nor merged
 * @property {readonly Piece[]} pieces in order of time
 * @property {Reading|null} reading    the fused class of its frames; null: no frame voted
 *
 * @typedef {object} Reading
 * @property {number} class_id
 * @property {string|null} [word]            the engine's name for it, if the set has no label for it
 * @property {number} share
 * @property {number|null} runner_up
 * @property {string|null} [runner_up_word]
 * @property {number} runner_up_share  0 without a runner-up
 */
import { partitionPoint, upperBound } from './binary_search.js';
import { NO_CLASS } from './documents.js';
import { eventSentences } from './describe_events.js';
import { trackName } from './track_name.js';

/** Classes whose votes are reported, as in the engine's lanes. */
const MAX_CLASSES = 6;
/** Fields of a lane that are not columns with one entry per frame. @type {ReadonlySet<keyof TrackLane>} */
const NOT_BY_FRAME = new Set(
  /** @type {const} */ (['id', 'tau', 'symmetry_floor', 'classes', 'words', 'events', 'votes', 'probabilities']),
);

/** The last request and its result, because lanes and inspector make the same request. @type {{requestKey: string, lanes: readonly TrackLane[], lane: DocumentLane|null}|null} */
let latest = null;

/**
 * The engine's tracks behind a track.
 *
 * @param {string} key
 * @param {TrackDoc|undefined} doc   undefined: nobody has changed it
 * @returns {number[]} empty: a person drew it
 */
export function engineTracksOf(key, doc) {
  if (doc) return [...new Set(doc.segments.map(({ track }) => track))];
  return key.startsWith('m') ? [Number(key.slice(1))] : [];
}

/**
 * The pieces of engine tracks in a document, in order. A piece that was split and merged again is one.
 *
 * @param {TrackDoc} doc
 * @returns {import('../types.js').Segment[]}
 */
export function piecesOfDocument(doc) {
  /** @type {import('../types.js').Segment[]} */
  const found = [];
  for (const piece of [...doc.segments].sort((a, b) => a.first - b.first || a.track - b.track)) {
    const before = found.at(-1);
    if (before?.track === piece.track && piece.first === before.last + 1) found[found.length - 1] = { ...before, last: piece.last };
    else found.push(piece);
  }
  return found;
}

/** Whether all lanes of a track are loaded. If so, a missing lane means that the engine has no frame of it. @param {string} key @param {TrackDoc|undefined} doc @param {Record<number, TrackLane>} lanes */
export const isLoaded = (key, doc, lanes) => engineTracksOf(key, doc).every((track) => lanes[track] !== undefined);

/**
 * The lane of a track.
 *
 * @param {string} key
 * @param {TrackDoc|undefined} doc            undefined: nobody has changed it
 * @param {Record<number, TrackLane>} lanes   the loaded lanes, by engine track
 * @returns {DocumentLane|null} null: not completely loaded, or the engine has no frame of it; the same object for the same lanes
 */
export function documentLane(key, doc, lanes) {
  if (!isLoaded(key, doc, lanes)) return null;
  const loaded = engineTracksOf(key, doc).map((track) => lanes[track]);
  const segments = doc && piecesOfDocument(doc);
  const requestKey = segments ? segments.map(({ track, first, last }) => `${track}:${first}-${last}`).join() : key;
  if (latest === null || latest.requestKey !== requestKey || latest.lanes.some((lane, i) => lane !== loaded[i])) {
    latest = {
      requestKey,
      lanes: loaded,
      lane: joinPieces(segments ? piecesOf(segments, lanes) : loaded.map((lane) => ({ lane, from: 0, to: lane.frame.length }))),
    };
  }
  return latest.lane;
}

/**
 * The events of a track in frame order: those of its pieces, and the places where these were split and merged.
 *
 * @param {DocumentLane} found
 * @returns {Sentence[]}
 */
export function sentencesOfTrack({ pieces, whole }) {
  if (whole) return eventSentences(pieces[0].lane);
  return pieces.flatMap((piece) => {
    const { lane, from, to } = piece;
    const [first, last] = [lane.frame[from], lane.frame[to - 1]];
    const sentences = eventSentences(lane).filter(({ frame }) => belongsTo(piece, frame));
    const name = trackName(`m${lane.id}`);
    if (from > 0 || pieces.length > 1)
      sentences.unshift({ frame: first, kind: 'joined', text: `from here on this is the engine’s track ${name}` });
    if (to < lane.frame.length)
      sentences.push({ frame: last, kind: 'cut', text: `the engine’s track ${name} continues, but not in this track` });
    return sentences;
  });
}

/**
 * Whether an event at a frame belongs to a piece. Events before an engine track or after it, such as its death, belong
 * to the piece with its first or last frame.
 *
 * @param {Piece} piece
 * @param {number} frame
 */
function belongsTo({ lane, from, to }, frame) {
  return (from === 0 || lane.frame[from] <= frame) && (to === lane.frame.length || frame <= lane.frame[to - 1]);
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
    const from = partitionPoint(0, lane.frame.length, (i) => lane.frame[i] < first);
    const to = upperBound(lane.frame, last);
    if (from < to) found.push({ lane, from, to });
  }
  return found;
}

/** @param {Piece[]} pieces @returns {DocumentLane|null} */
function joinPieces(pieces) {
  if (pieces.length === 0) return null;
  const [{ lane, from, to }] = pieces;
  const whole = pieces.length === 1 && from === 0 && to === lane.frame.length;
  const track = pieces.flatMap((piece) => new Array(piece.to - piece.from).fill(piece.lane.id));
  const all = whole ? lane : fuseLanes(pieces);
  return { lane: all, track, whole, pieces, reading: readingOf(all) };
}

/** @param {Piece[]} pieces @returns {TrackLane} */
function fuseLanes(pieces) {
  const { classes, words, votes, probabilities } = fuseVotes(pieces);
  /** @param {keyof TrackLane} name */
  const column = (name) => pieces.flatMap(({ lane, from, to }) => /** @type {unknown[]} */ (lane[name]).slice(from, to));
  const columns = /** @type {(keyof TrackLane)[]} */ (Object.keys(pieces[0].lane)).filter((name) => !NOT_BY_FRAME.has(name));
  return /** @type {TrackLane} */ ({
    .../** @type {object} */ (Object.fromEntries(columns.map((name) => [name, column(name)]))),
    id: pieces[0].lane.id,
    tau: pieces[0].lane.tau,
    symmetry_floor: pieces[0].lane.symmetry_floor,
    classes,
    words,
    votes,
    probabilities,
    events: pieces.flatMap((piece) => piece.lane.events.filter(({ frame }) => belongsTo(piece, frame))),
  });
}

/**
 * Cumulative votes and P in each entry, for the classes that lead at the end. A lane has P of the leading classes of
 * the whole engine track. The class that a frame was read as counts even if it is not among them.
 *
 * @param {Piece[]} pieces
 * @returns {{classes: number[], words: (string|null)[], votes: (number[]|null)[], probabilities: (number[]|null)[]}}
 */
function fuseVotes(pieces) {
  /** P by label, or by the engine's name, for each entry. @type {(Map<number|string, number>|null)[]} */
  const probabilityMaps = [];
  /** @type {(number|null)[]} */
  const weights = [];
  for (const { lane, from, to } of pieces) {
    for (let i = from; i < to; i += 1) {
      const known = lane.probabilities[i];
      const [top, p] = [lane.top_word?.[i] ?? lane.top[i], lane.top_probability[i]];
      const all = known && new Map(lane.classes.map((id, c) => /** @type {[number|string, number]} */ ([lane.words?.[c] ?? id, known[c]])));
      if (all && top !== null && p !== null && !all.has(top)) all.set(top, p);
      probabilityMaps.push(all);
      weights.push(all && lane.weight[i]);
    }
  }
  /** @type {Map<number|string, number>} */
  const sums = new Map();
  probabilityMaps.forEach((all, i) => all?.forEach((p, id) => sums.set(id, (sums.get(id) ?? 0) + (weights[i] ?? 0) * p)));
  const leading = [...sums]
    .filter(([, sum]) => sum > 0)
    .sort((a, b) => b[1] - a[1] || (a[0] < b[0] ? -1 : 1))
    .slice(0, MAX_CLASSES)
    .map(([id]) => id);
  const probabilities = probabilityMaps.map((all) => all && leading.map((id) => all.get(id) ?? 0));
  const cumulative = new Float64Array(leading.length);
  let totalWeight = 0;
  const votes = probabilities.map((shares, i) => {
    const weight = weights[i];
    if (shares === null || weight === null) return null;
    totalWeight += weight;
    shares.forEach((p, c) => {
      cumulative[c] += weight * p;
    });
    return Array.from(cumulative, (sum) => sum / totalWeight);
  });
  const classes = leading.map((id) => (typeof id === 'string' ? NO_CLASS : id));
  return { classes, words: leading.map((id) => (typeof id === 'string' ? id : null)), votes, probabilities };
}

/** Shares of the lane's `classes` after all its frames have voted; null: no frame voted. @param {Pick<TrackLane, 'votes'>} lane @returns {number[]|null} */
export const lastVotes = ({ votes }) => votes.filter((shares) => shares !== null).at(-1) ?? null;

/** @param {TrackLane} lane @returns {Reading|null} */
function readingOf(lane) {
  const last = lastVotes(lane);
  if (!last || lane.classes.length === 0) return null;
  const [word = null, runner_up_word = null] = lane.words ?? [];
  return {
    class_id: lane.classes[0],
    word,
    share: last[0],
    runner_up: lane.classes[1] ?? null,
    runner_up_word,
    runner_up_share: last[1] ?? 0,
  };
}

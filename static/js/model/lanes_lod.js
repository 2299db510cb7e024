// @ts-check
/**
 * The tracks of a whole drive in typed arrays, so that drawing a panned frame allocates nothing: bars sorted by row and
 * time, their parts by source, their key frames, and a pyramid of density and uncertainty for the overview. Pure.
 *
 * @typedef {import('../types.js').LaneColumns} LaneColumns
 * @typedef {import('../types.js').TrackDoc} TrackDoc
 * @typedef {import('./track_entries.js').TrackEntry} TrackEntry
 *
 * @typedef {object} LaneIndex
 * @property {number} count            number of bars
 * @property {number} rows
 * @property {string[]} key            of each bar, by row and then time
 * @property {Map<string, number>} barOf   bar of a key
 * @property {Int32Array} first
 * @property {Int32Array} last
 * @property {Int32Array} row
 * @property {Int32Array} classId      `NO_CLASS`: none
 * @property {Uint8Array} review       0 open, 1 accepted, 2 rejected, 3 needs work
 * @property {Int32Array} rowStart     bars of row r: rowStart[r] .. rowStart[r + 1]
 * @property {Int32Array} pieceStart   pieces of bar b: pieceStart[b] .. pieceStart[b + 1]
 * @property {Int32Array} pieceFirst
 * @property {Int32Array} pieceLast
 * @property {Uint8Array} pieceSource  0 detected, 1 predicted, 2 relocalised, 3 corrected
 * @property {Int32Array} keyStart
 * @property {Int32Array} keyFrame     key frames
 *
 * @typedef {object} Density
 * @property {number} bucket           frames per bucket on the finest level
 * @property {Float32Array[]} tracks   by level, finest first: largest number of simultaneous tracks in a bucket
 * @property {Float32Array[]} uncertainty    by level: largest uncertainty in a bucket
 * @property {number} maxTracks             maximum over all buckets
 */
import { partitionPoint } from './binary_search.js';
import { NO_CLASS, keyFramesOf } from './documents.js';
import { labelName } from './labels.js';
import { clamp } from './geometry.js';
import { packIntervals } from './interval_packing.js';

export const CORRECTED = 3;
/** @type {Record<TrackDoc['review'], number>} */
const REVIEW = { open: 0, accepted: 1, rejected: 2, needs_work: 3 };
/** Minimum distance of two bars in a row, frames. */
const MIN_BAR_GAP_FRAMES = 4;

/** @param {TrackEntry} entry */
const classIdOf = (entry) => entry.class_id ?? NO_CLASS;

/**
 * The text on a bar.
 * @param {readonly import('../types.js').Label[]} labels
 * @param {number} classId   as stored in the index
 */
export const barName = (labels, classId) => labelName(labels, classId === NO_CLASS ? null : classId);

/**
 * @param {readonly TrackEntry[]} entries
 * @param {LaneColumns|null} lanes   sorted by track, then frame
 * @param {Record<string, TrackDoc>} docs
 * @returns {LaneIndex}
 */
export function buildLaneIndex(entries, lanes, docs) {
  const packed = packIntervals(
    entries.map((entry) => entry.first),
    entries.map((entry) => entry.last),
    MIN_BAR_GAP_FRAMES,
  );
  const order = entries.map((_, i) => i);
  order.sort((a, b) => packed.row[a] - packed.row[b] || entries[a].first - entries[b].first);
  const count = entries.length;
  const index = emptyIndex(count, packed.rows);
  const { start, stop } = piecesByTrack(lanes);
  /** @type {number[]} */
  const pieces = [];
  /** @type {number[]} */
  const keys = [];
  order.forEach((position, bar) => {
    const entry = entries[position];
    index.key[bar] = entry.key;
    index.barOf.set(entry.key, bar);
    index.first[bar] = entry.first;
    index.last[bar] = entry.last;
    index.row[bar] = packed.row[position];
    index.classId[bar] = classIdOf(entry);
    index.review[bar] = REVIEW[entry.review];
    index.rowStart[packed.row[position] + 1] = bar + 1;
    const doc = docs[entry.key];
    const spans = doc ? doc.segments : [{ track: entry.track ?? -1, first: entry.first, last: entry.last }];
    for (const span of spans) {
      for (let i = start.get(span.track) ?? 0; lanes && i < (stop.get(span.track) ?? 0); i += 1) {
        const from = Math.max(lanes.first[i], span.first);
        const to = Math.min(lanes.last[i], span.last);
        for (const [first, last] of entry.spans) {
          if (Math.max(from, first) <= Math.min(to, last)) pieces.push(Math.max(from, first), Math.min(to, last), lanes.source[i]);
        }
      }
    }
    if (doc) addCorrections(doc, entry, pieces, keys);
    index.pieceStart[bar + 1] = pieces.length / 3;
    index.keyStart[bar + 1] = keys.length;
  });
  for (let r = 1; r <= packed.rows; r += 1) index.rowStart[r] = Math.max(index.rowStart[r], index.rowStart[r - 1]);
  const total = pieces.length / 3;
  index.pieceFirst = new Int32Array(total);
  index.pieceLast = new Int32Array(total);
  index.pieceSource = new Uint8Array(total);
  for (let i = 0; i < total; i += 1) {
    index.pieceFirst[i] = pieces[3 * i];
    index.pieceLast[i] = pieces[3 * i + 1];
    index.pieceSource[i] = pieces[3 * i + 2];
  }
  index.keyFrame = Int32Array.from(keys);
  return index;
}

/**
 * The index after verdicts or new labels, without a rebuild, because the bars have not moved.
 *
 * @param {LaneIndex} index
 * @param {readonly TrackEntry[]} entries   after the change
 * @param {Record<string, TrackDoc>} before
 * @param {Record<string, TrackDoc>} docs
 * @returns {LaneIndex|null} null: bars, parts or key frames have changed, so it must be rebuilt
 */
export function withVerdicts(index, entries, before, docs) {
  if (entries.length !== index.count) return null;
  for (const key in before) if (!(key in docs)) return null;
  /** @type {Set<string>} */
  const changed = new Set();
  for (const key in docs) {
    if (docs[key] === before[key]) continue;
    if (!sameExtent(index, key, before[key], docs[key])) return null;
    changed.add(key);
  }
  const review = index.review.slice();
  const classId = index.classId.slice();
  for (const entry of entries) {
    if (!changed.has(entry.key)) continue;
    const bar = /** @type {number} */ (index.barOf.get(entry.key));
    review[bar] = REVIEW[entry.review];
    classId[bar] = classIdOf(entry);
  }
  return { ...index, review, classId };
}

/**
 * @param {LaneIndex} index
 * @param {string} key
 * @param {TrackDoc|undefined} before   undefined: nobody had changed the engine's track
 * @param {TrackDoc} doc
 */
function sameExtent(index, key, before, doc) {
  const bar = index.barOf.get(key);
  if (before !== undefined) {
    const extent = (/** @type {TrackDoc} */ { gone, segments, keys }) => JSON.stringify([gone, segments, keys]);
    return (before.segments === doc.segments && before.keys === doc.keys && before.gone === doc.gone) || extent(before) === extent(doc);
  }
  if (bar === undefined || doc.gone || doc.segments.length !== 1 || Object.keys(doc.keys).length > 0) return false;
  const [{ track, first, last }] = doc.segments;
  return key === `m${track}` && first === index.first[bar] && last === index.last[bar];
}

/**
 * The first index in a sorted part of an array whose value is at least `value`.
 *
 * @param {Int32Array} values
 * @param {number} from
 * @param {number} to        exclusive
 * @param {number} value
 * @returns {number} from..to
 */
export const lowerBound = (values, from, to, value) => partitionPoint(from, to, (i) => values[i] < value);

/**
 * The bar at a row and frame.
 *
 * @param {LaneIndex} index
 * @param {number} row
 * @param {number} frame
 * @param {number} slack   tolerance to each side of a bar, frames
 * @returns {number} -1: none
 */
export function barAt(index, row, frame, slack) {
  if (row < 0 || row >= index.rows) return -1;
  const start = index.rowStart[row];
  const stop = index.rowStart[row + 1];
  const exact = lowerBound(index.last, start, stop, Math.floor(frame));
  if (exact < stop && index.first[exact] <= frame) return exact;
  const bar = lowerBound(index.last, start, stop, Math.floor(frame - slack));
  return bar < stop && index.first[bar] - slack <= frame ? bar : -1;
}

/**
 * Density of tracks and uncertainty over a drive, finest level first; each further level joins two buckets.
 *
 * @param {readonly TrackEntry[]} entries
 * @param {number} frames   of the drive
 * @param {number} [bucket]   frames per bucket on the finest level; fewer for a drive so short that buckets would be visible
 * @returns {Density}
 */
export function buildDensity(entries, frames, bucket = Math.min(16, Math.max(1, Math.floor(frames / 1024)))) {
  const size = Math.max(1, Math.ceil(frames / bucket));
  const change = new Float32Array(size + 1);
  const uncertainty = new Float32Array(size);
  for (const entry of entries) {
    const from = clamp(Math.floor(entry.first / bucket), 0, size - 1);
    const to = clamp(Math.floor(entry.last / bucket), from, size - 1);
    change[from] += 1;
    change[to + 1] -= 1;
    const open = entry.review === 'open' || entry.review === 'needs_work' ? (entry.uncertainty ?? 0) : 0;
    for (let b = from; b <= to; b += 1) if (uncertainty[b] < open) uncertainty[b] = open;
  }
  const tracks = new Float32Array(size);
  let running = 0;
  let maxTracks = 0;
  for (let b = 0; b < size; b += 1) {
    running += change[b];
    tracks[b] = running;
    maxTracks = Math.max(maxTracks, running);
  }
  return { bucket, tracks: pyramid(tracks), uncertainty: pyramid(uncertainty), maxTracks };
}

/**
 * The level of a pyramid with about one bucket per pixel.
 *
 * @param {Density} density
 * @param {number} framesPerPixel
 * @returns {number}
 */
export function levelFor(density, framesPerPixel) {
  const level = Math.floor(Math.log2(Math.max(1, framesPerPixel / density.bucket)));
  return clamp(level, 0, density.tracks.length - 1);
}

/** @param {Float32Array} finest @returns {Float32Array[]} */
function pyramid(finest) {
  const levels = [finest];
  while (levels[levels.length - 1].length > 64) {
    const fine = levels[levels.length - 1];
    const coarse = new Float32Array(Math.ceil(fine.length / 2));
    for (let i = 0; i < fine.length; i += 1) coarse[i >> 1] = Math.max(coarse[i >> 1], fine[i]);
    levels.push(coarse);
  }
  return levels;
}

/**
 * @param {LaneColumns|null} lanes
 * @returns {{start: Map<number, number>, stop: Map<number, number>}} range of each track's parts
 */
function piecesByTrack(lanes) {
  const start = new Map();
  const stop = new Map();
  for (let i = 0; lanes && i < lanes.track.length; i += 1) {
    if (!start.has(lanes.track[i])) start.set(lanes.track[i], i);
    stop.set(lanes.track[i], i + 1);
  }
  return { start, stop };
}

/**
 * Spans between interpolated key frames count as corrected and are painted over the engine's parts.
 *
 * @param {TrackDoc} doc
 * @param {TrackEntry} entry
 * @param {number[]} pieces   first, last, source; is appended to
 * @param {number[]} keys     is appended to
 */
function addCorrections(doc, entry, pieces, keys) {
  const frames = keyFramesOf(doc);
  frames.forEach((frame, i) => {
    keys.push(frame);
    const key = doc.keys[frame];
    if (key.outside || key.box === null) return;
    const next = frames[i + 1];
    pieces.push(frame, key.interpolate && next !== undefined ? Math.min(next - 1, entry.last) : frame, CORRECTED);
  });
}

/** @param {number} count @param {number} rows @returns {LaneIndex} */
function emptyIndex(count, rows) {
  return {
    count,
    rows,
    key: new Array(count),
    barOf: new Map(),
    first: new Int32Array(count),
    last: new Int32Array(count),
    row: new Int32Array(count),
    classId: new Int32Array(count),
    review: new Uint8Array(count),
    rowStart: new Int32Array(rows + 1),
    pieceStart: new Int32Array(count + 1),
    pieceFirst: new Int32Array(0),
    pieceLast: new Int32Array(0),
    pieceSource: new Uint8Array(0),
    keyStart: new Int32Array(count + 1),
    keyFrame: new Int32Array(0),
  };
}

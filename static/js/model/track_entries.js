// @ts-check
/**
 * The tracks of a run with people's corrections, one entry per track: the data of queue and lanes. Pure.
 *
 * @typedef {import('../state-types.js').ReviewState} ReviewState
 * @typedef {import('../types.js').TrackColumns} TrackColumns
 * @typedef {import('../types.js').TrackDoc} TrackDoc
 *
 * @typedef {object} TrackEntry
 * @property {string} key             `m7` or `h...`
 * @property {string} name            as shown: `#7`, `drawn at 88`
 * @property {number|null} track      number of the engine's track; null: made by a person
 * @property {number} column          index in the columns of the run; -1: none
 * @property {boolean} whole          exactly that engine track: neither split nor merged
 * @property {number} first           first frame
 * @property {number} last            last frame, inclusive
 * @property {readonly import('./join.js').Span[]} spans   ranges of frames in which it shows something
 * @property {number|null} class_id   a person's label, also `NO_CLASS`, else the engine's
 * @property {boolean} relabelled     the label is a person's
 * @property {number|null} uncertainty      probability that a person changes it, 0..1; null: not known
 * @property {number} rank            its rank in the queue when the columns were loaded; later edits do not change it
 * @property {number} score           best final score; NaN: no detection
 * @property {string|null} word         the engine's name for it, if that is its label and the set has no such label
 * @property {string[]} reasons       plain sentences
 * @property {TrackDoc['review']} review   also `rejected` if an older version marked it as not a sign
 * @property {boolean} ignore         neither a sign nor background
 * @property {readonly string[]} notes   their texts
 * @property {TrackDoc|null} doc      its corrections; null: none
 * @property {readonly string[]} answers   attributes that people have set, in any frame: `ground=red`
 */
import { answerText } from './attributes.js';
import { NO_CLASS, verdictOf } from './documents.js';
import { spanOf } from './effective.js';
import { shownSpans } from './shown_spans.js';
import { piecesOfDocument } from './track_lane.js';
import { trackName } from './track_name.js';

/** The last request and its result, because queue, lanes and inspector make the same request. @type {{tracks: TrackColumns|null, docs: Record<string, TrackDoc>, entries: readonly TrackEntry[]}|null} */
let latest = null;

/**
 * Every existing track: engine tracks in the order of the run, then people's own by first frame.
 *
 * @param {TrackColumns|null} tracks
 * @param {Record<string, TrackDoc>} docs
 * @returns {readonly TrackEntry[]} the same list for the same arguments
 */
export function trackEntries(tracks, docs) {
  if (latest === null || latest.tracks !== tracks || latest.docs !== docs) latest = { tracks, docs, entries: buildEntries(tracks, docs) };
  return latest.entries;
}

/** @param {TrackColumns|null} tracks @param {Record<string, TrackDoc>} docs @returns {TrackEntry[]} */
function buildEntries(tracks, docs) {
  /** @type {TrackEntry[]} */
  const entries = [];
  /** @type {Map<number, number>} */
  const columnOf = new Map();
  const count = tracks ? tracks.id.length : 0;
  for (let i = 0; tracks && i < count; i += 1) {
    columnOf.set(tracks.id[i], i);
    const key = `m${tracks.id[i]}`;
    const doc = docs[key];
    if (doc === undefined) entries.push(engineEntry(tracks, i, key));
    else if (!doc.gone) entries.push(documentEntry(tracks, columnOf, doc, i));
  }
  /** @type {TrackEntry[]} */
  const humanEntries = [];
  for (const key in docs) {
    const doc = docs[key];
    if (doc.gone || (key.startsWith('m') && columnOf.has(Number(key.slice(1))))) continue;
    const column = doc.segments.length > 0 ? (columnOf.get(doc.segments[0].track) ?? -1) : -1;
    humanEntries.push(documentEntry(tracks, columnOf, doc, column));
  }
  humanEntries.sort((a, b) => a.first - b.first || (a.key < b.key ? -1 : 1));
  return entries.concat(humanEntries);
}

/** @param {TrackColumns} tracks @param {number} i @param {string} key @returns {TrackEntry} */
function engineEntry(tracks, i, key) {
  return {
    key,
    name: trackName(key),
    track: tracks.id[i],
    column: i,
    whole: true,
    first: tracks.first[i],
    last: tracks.last[i],
    spans: [[tracks.first[i], tracks.last[i]]],
    class_id: tracks.class_id[i],
    word: tracks.word?.[i] ?? null,
    relabelled: false,
    uncertainty: tracks.uncertainty[i],
    rank: tracks.rank[i],
    score: tracks.score[i] ?? Number.NaN,
    reasons: tracks.reasons[i] ?? [],
    review: 'open',
    ignore: false,
    notes: [],
    doc: null,
    answers: [],
  };
}

/**
 * @param {TrackColumns|null} tracks
 * @param {Map<number, number>} columnOf
 * @param {TrackDoc} doc
 * @param {number} column
 * @returns {TrackEntry}
 */
function documentEntry(tracks, columnOf, doc, column) {
  const hasColumn = tracks !== null && column >= 0;
  const isEngineTrack = doc.key.startsWith('m') && column >= 0;
  /** @param {number} track */
  const lastOf = (track) => {
    const index = columnOf.get(track);
    return index === undefined || tracks === null ? null : tracks.last[index];
  };
  const spans = shownSpans(doc, lastOf);
  const span = spans.length > 0 ? { first: spans[0][0], last: spans[spans.length - 1][1] } : spanOf(doc, lastOf);
  const first = span?.first ?? (hasColumn ? tracks.first[column] : 0);
  return {
    key: doc.key,
    name: trackName(doc.key, doc),
    track: isEngineTrack && tracks ? tracks.id[column] : null,
    column: hasColumn ? column : -1,
    whole: hasColumn && isWhole(tracks, column, doc),
    first,
    last: span?.last ?? first,
    spans,
    class_id: doc.class_id ?? (hasColumn ? tracks.class_id[column] : null),
    word: hasColumn && doc.class_id === null ? (tracks.word?.[column] ?? null) : null,
    relabelled: doc.class_id !== null,
    uncertainty: hasColumn ? uncertaintyOf(tracks, column, doc) : 0,
    rank: hasColumn ? tracks.rank[column] : 0,
    score: hasColumn ? tracks.score[column] : Number.NaN,
    reasons: hasColumn ? reasonsOf(tracks, column, doc) : ['A person drew it.'],
    review: verdictOf(doc),
    ignore: doc.ignore === true,
    notes: doc.notes.map(({ text }) => text),
    doc,
    answers: answersOf(doc),
  };
}

/** @param {TrackDoc} doc @returns {string[]} */
function answersOf(doc) {
  const attributeSets = [doc.attributes, ...Object.values(doc.keys).map(({ attributes }) => attributes)];
  return [...new Set(attributeSets.flatMap((one) => Object.entries(one ?? {}).map(([name, value]) => `${name}=${answerText(value)}`)))];
}

/**
 * Whether a person calls an engine's track something else. The twin of `overruled` in app/evidence/disagreement.py,
 * except that a mark as not a sign counts as a review state here.
 *
 * @param {TrackColumns} tracks
 * @param {number} column
 * @param {TrackDoc} doc
 */
function overruled(tracks, column, doc) {
  return doc.class_id !== null && doc.class_id !== (tracks.class_id[column] ?? NO_CLASS);
}

/** @param {TrackDoc} doc */
const isDecided = (doc) => ['accepted', 'rejected'].includes(verdictOf(doc));

/** @param {TrackColumns} tracks @param {number} column @param {TrackDoc} doc */
function uncertaintyOf(tracks, column, doc) {
  return overruled(tracks, column, doc) && !isDecided(doc) ? 1 : tracks.uncertainty[column];
}

/** @param {TrackColumns} tracks @param {number} column @param {TrackDoc} doc @returns {string[]} */
function reasonsOf(tracks, column, doc) {
  const found = [];
  if (overruled(tracks, column, doc) && !isDecided(doc)) found.push('A person calls it something else than the engine.');
  const engineReasons = tracks.reasons[column];
  if (engineReasons.length > 0 && !isWhole(tracks, column, doc))
    found.push(`About ${trackName(`m${tracks.id[column]}`)} as the engine made it:`);
  return found.concat(engineReasons);
}

/** Whether a document has exactly the frames of an engine track. @param {TrackColumns} tracks @param {number} column @param {TrackDoc} doc */
function isWhole(tracks, column, doc) {
  const [piece, ...others] = piecesOfDocument(doc);
  return piece !== undefined && others.length === 0 && piece.first <= tracks.first[column] && tracks.last[column] <= piece.last;
}

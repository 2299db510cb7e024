// @ts-check
/**
 * The queue: the tracks to review, their order, and the number that is left. Pure.
 *
 * @typedef {import('../state-types.js').State} State
 * @typedef {import('../state-types.js').QueueFilter} QueueFilter
 * @typedef {import('../types.js').Label} Label
 * @typedef {import('./track_entries.js').TrackEntry} TrackEntry
 *
 * @typedef {object} QueueCounts
 * @property {number} total
 * @property {number} open
 * @property {number} accepted
 * @property {number} rejected
 * @property {number} needs_work
 * @property {number} left        open and needs work: without a decision
 */
import { hasAttribute } from './attributes.js';
import { NO_CLASS } from './documents.js';
import { engineName, labelFor, resolveLabelId } from './labels.js';
import { plural } from './format.js';
import { trackEntries } from './track_entries.js';

/** @type {QueueFilter} */
export const NO_FILTER = Object.freeze({
  class_id: null,
  review: 'all',
  least_uncertainty: 0,
  least_score: null,
  most_score: null,
  with_notes: false,
  attribute: null,
  text: '',
  sort: 'uncertainty',
});

/**
 * The sorted queue with the page's filter applied.
 *
 * @param {Pick<State, 'review'|'labels'>} state
 * @returns {TrackEntry[]} empty outside the review screen
 */
export function shownQueue({ review, labels }) {
  return review === null ? [] : queueOf(trackEntries(review.tracks, review.docs), review.filter, labels);
}

/**
 * The track that follows the selected one. A selected track that the filter hides, for example because it was just
 * accepted, keeps its place in the order, so that navigation continues from there.
 *
 * Forward goes to the next undecided track, unless the filter selects one state or no track is undecided. Back goes to
 * the previous track, decided or not, so that a verdict can be checked again.
 *
 * @param {State} state
 * @param {1|-1} direction
 * @returns {string|null} null: none in that direction
 */
export function nextInQueue(state, direction) {
  const review = state.review;
  if (review === null) return null;
  const entries = trackEntries(review.tracks, review.docs);
  const queue = queueOf(entries, review.filter, state.labels);
  const selected = entries.find((entry) => entry.key === review.selected);
  const others = queue.filter((entry) => entry !== selected);
  const compare = comparator(review.filter.sort, state.labels);
  const before =
    selected === undefined ? (direction > 0 ? 0 : others.length) : others.filter((entry) => compare(entry, selected) < 0).length;
  if (direction < 0) return others[before - 1]?.key ?? null;
  const onlyUndecided = review.filter.review === 'all' && others.some(isUndecided);
  return others.slice(before).find((entry) => !onlyUndecided || isUndecided(entry))?.key ?? null;
}

/** Whether the track needs a decision. @param {TrackEntry} entry */
const isUndecided = ({ review }) => review === 'open' || review === 'needs_work';

/**
 * The message at an end of the queue. It counts the undecided tracks that were skipped.
 *
 * @param {State} state
 * @param {1|-1} direction
 * @returns {string}
 */
export function endOfQueue(state, direction) {
  const end = direction > 0 ? 'This is the end of the queue.' : 'This is the beginning of the queue.';
  const { left } = queueCounts(shownQueue(state).filter(({ key }) => key !== state.review?.selected));
  if (left === 0) return end;
  const [where, way] = direction > 0 ? ['before', ': press Esc, then J'] : ['after', ''];
  return `${end} ${plural(left, 'track')} ${where} this one ${left === 1 ? 'is' : 'are'} still to be decided${way}.`;
}

/**
 * Entries that pass a filter, in the filter's order.
 *
 * @param {readonly TrackEntry[]} entries
 * @param {QueueFilter} filter
 * @param {readonly Label[]} labels   for names, and to resolve merged labels
 * @returns {TrackEntry[]}
 */
export function queueOf(entries, filter, labels) {
  const words = filter.text.toLowerCase().split(/\s+/).filter(Boolean);
  return entries
    .filter((entry) => passes(entry, filter, labels) && words.every((word) => mentions(entry, word, labels)))
    .sort(comparator(filter.sort, labels));
}

/**
 * The smallest and the largest score of the tracks.
 *
 * @param {readonly TrackEntry[]} entries
 * @returns {[number, number]|null} null: no track has a score
 */
export function scoreRange(entries) {
  let [low, high] = [Infinity, -Infinity];
  for (const { score } of entries) {
    if (score < low) low = score;
    if (score > high) high = score;
  }
  return low <= high ? [low, high] : null;
}

/** @param {readonly TrackEntry[]} entries @returns {QueueCounts} */
export function queueCounts(entries) {
  const counts = { total: entries.length, open: 0, accepted: 0, rejected: 0, needs_work: 0, left: 0 };
  for (const entry of entries) counts[entry.review] += 1;
  counts.left = entries.filter(isUndecided).length;
  return counts;
}

/** @param {TrackEntry} entry @param {QueueFilter} filter @param {readonly Label[]} labels */
function passes(entry, filter, labels) {
  return (
    (filter.class_id === null || resolveLabelId(labels, entry.class_id ?? NO_CLASS) === resolveLabelId(labels, filter.class_id)) &&
    (filter.review === 'all' || entry.review === filter.review) &&
    (!filter.with_notes || entry.notes.length > 0) &&
    (filter.attribute === null ||
      hasAttribute(labelFor(labels, entry.class_id), entry.doc, filter.attribute.name, filter.attribute.value)) &&
    (filter.least_uncertainty === 0 || (entry.uncertainty !== null && entry.uncertainty >= filter.least_uncertainty)) &&
    // a track without a score is neither above nor below a limit
    (filter.least_score === null || entry.score >= filter.least_score) &&
    (filter.most_score === null || entry.score <= filter.most_score)
  );
}

/** @param {TrackEntry} entry @param {string} word @param {readonly Label[]} labels */
function mentions(entry, word, labels) {
  if (entry.name === word || (entry.track !== null && String(entry.track) === word)) return true;
  if (entry.track === null && entry.name.includes(word)) return true;
  const label = labelFor(labels, entry.class_id);
  if (label && [label.name, label.key, ...label.aliases].some((text) => text.toLowerCase().includes(word))) return true;
  if (entry.class_id === NO_CLASS && engineName(labels, NO_CLASS, entry.word).toLowerCase().includes(word)) return true;
  return [...entry.reasons, ...entry.notes, ...entry.answers].some((text) => text.toLowerCase().includes(word));
}

/**
 * A total order, so that equal tracks keep their places.
 *
 * @param {QueueFilter['sort']} sort
 * @param {readonly Label[]} labels   in the order of the set
 * @returns {(a: TrackEntry, b: TrackEntry) => number}
 */
function comparator(sort, labels) {
  /** @param {TrackEntry} a @param {TrackEntry} b */
  const tie = (a, b) => a.first - b.first || (a.key < b.key ? -1 : a.key > b.key ? 1 : 0);
  switch (sort) {
    case 'time':
      return tie;
    case 'class': {
      const positions = new Map(labels.map(({ id }, place) => [id, place]));
      /** Tracks without a label come last. @param {TrackEntry} entry */
      const position = ({ class_id }) => positions.get(resolveLabelId(labels, class_id ?? NO_CLASS)) ?? 1e9;
      return (a, b) => position(a) - position(b) || tie(a, b);
    }
    case 'score':
      return (a, b) => scoreOrMax(a.score) - scoreOrMax(b.score) || tie(a, b);
    default:
      return (a, b) => b.rank - a.rank || tie(a, b); // not by uncertainty: it changes with an edit, and rows would move under the pointer
  }
}

/** @param {number} score @returns {number} tracks without a score come last */
function scoreOrMax(score) {
  return Number.isFinite(score) ? score : Number.MAX_VALUE;
}

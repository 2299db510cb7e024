// @ts-check
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { NO_FILTER, endOfQueue, nextInQueue, queueCounts, queueOf, scoreRange, shownQueue } from '../../../static/js/model/queue.js';
import { trackEntries } from '../../../static/js/model/track_entries.js';
import { NO_CLASS, blankDoc, emptyDoc } from '../../../static/js/model/documents.js';
import { syntheticRun } from '../harness/synthetic_run.js';
import { attribute, label } from '../labels.js';
import { pluck } from '../pluck.js';
import { keyFrame } from '../server_data.js';

const LABELS = [
  label({ id: 1, name: 'Yield', aliases: ['give way'] }),
  label({ id: 2, name: 'Stop' }),
  label({ id: 9, name: 'Halt', merged_into: 2 }),
];

/**
 * @param {object} [docs]
 * @param {object} [filter]
 * @param {string|null} [selected]
 * @returns {any} three tracks: uncertainty 0.1, 0.9, 0.5
 */
function state(docs = {}, filter = {}, selected = null) {
  const tracks = {
    ...syntheticRun(1000, 3).tracks,
    id: [1, 2, 3],
    uncertainty: [0.1, 0.9, 0.5],
    rank: [0.1, 0.9, 0.5],
    class_id: [1, 2, 1],
    first: [30, 20, 10],
    last: [40, 30, 20],
    score: [3, 2, 1],
    reasons: [[], ['It is short: 11 frames.'], []],
  };
  return { labels: LABELS, review: { tracks, docs, filter: { ...NO_FILTER, ...filter }, selected } };
}
const doc = (/** @type {number} */ track, /** @type {object} */ change) => ({ ...emptyDoc({ track, first: 10, last: 40 }), ...change });

/** Keys in their order. @param {Parameters<typeof shownQueue>[0]} state */
const queueOrder = (state) => shownQueue(state).map(({ key }) => key);

test('the most uncertain track comes first', () => assert.deepEqual(queueOrder(state()), ['m2', 'm3', 'm1']));

for (const [sort, order] of /** @type {const} */ ([
  ['time', ['m3', 'm2', 'm1']],
  ['class', ['m3', 'm1', 'm2']],
  ['score', ['m3', 'm2', 'm1']],
])) {
  test(`order by ${sort}`, () => assert.deepEqual(queueOrder(state({}, { sort })), order));
}

for (const [filter, order] of /** @type {[object, string[]][]} */ ([
  [{ class_id: 2 }, ['m2']],
  [{ least_uncertainty: 0.4 }, ['m2', 'm3']],
  [{ text: 'yield' }, ['m3', 'm1']],
  [{ text: '#3' }, ['m3']],
  [{ text: 'short' }, ['m2']],
  [{ text: 'nothing like it' }, []],
])) {
  test(`filter ${JSON.stringify(filter)}`, () => assert.deepEqual(queueOrder(state({}, filter)), order));
}

test('tracks of an imported run have no uncertainty: they pass no minimum and are sorted by rank', () => {
  const imported = (/** @type {object} */ filter) => {
    const { labels, review } = state({}, filter);
    return /** @type {any} */ ({
      labels,
      review: { ...review, tracks: { ...review.tracks, uncertainty: [null, null, null], rank: [0, 0, 1] } },
    });
  };
  assert.deepEqual(queueOrder(imported({})), ['m3', 'm2', 'm1']);
  assert.deepEqual(queueOrder(imported({ least_uncertainty: 0.1 })), []);
});

test('the score filter has a minimum and a maximum; tracks without a score pass neither', () => {
  assert.deepEqual(queueOrder(state({}, { least_score: 2 })), ['m2', 'm1']);
  assert.deepEqual(queueOrder(state({}, { most_score: 2 })), ['m2', 'm3']);
  assert.deepEqual(queueOrder(state({}, { least_score: 1.5, most_score: 2.5 })), ['m2']);
  const drawn = { ...blankDoc('hab'), keys: { 5: keyFrame({ box: [0, 0, 9, 9] }) } };
  assert.deepEqual(queueOrder(state({ hab: drawn }, { most_score: 1 })), ['m3']);
  assert.equal(queueOrder(state({ hab: drawn })).length, 4);
  const entries = trackEntries(state({ hab: drawn }).review.tracks, { hab: drawn });
  assert.deepEqual(scoreRange(entries), [1, 3]);
  assert.equal(scoreRange(entries.filter(({ key }) => key === 'hab')), null);
});

test('notes are found by their words, and tracks with notes can be shown alone', () => {
  const note = (/** @type {string} */ text) => ({ id: text, frame: 12, text, author: 'ann', created: '' });
  const docs = { m1: doc(1, { notes: [note('Behind the Lorry'), note('ask Ben')] }), m3: doc(3, { notes: [] }) };
  assert.deepEqual(queueOrder(state(docs, { text: 'lorry' })), ['m1']);
  assert.deepEqual(queueOrder(state(docs, { text: 'yield ben' })), ['m1'], 'words of the class and of a note together');
  assert.deepEqual(queueOrder(state(docs, { text: 'lorries' })), []);
  assert.deepEqual(queueOrder(state(docs, { with_notes: true })), ['m1']);
  assert.deepEqual(queueOrder(state(docs, { with_notes: true, class_id: 2 })), []);
  assert.equal(queueOrder(state(docs)).length, 3);
});

test('tracks are filtered by an attribute value, or by the default value of their label', () => {
  const labels = [
    label({
      id: 1,
      name: 'Yield',
      attributes: [attribute({ name: 'dirty', default: false }), attribute({ name: 'lit', kind: 'text' })],
    }),
    label({ id: 2, name: 'Stop' }),
  ];
  const docs = {
    m1: doc(1, { attributes: { dirty: true }, keys: { 12: keyFrame({ attributes: { lit: 'dusk' } }) } }),
    m2: doc(2, { attributes: { lit: 'day' } }),
  };
  const order = (/** @type {any} */ wanted) => queueOrder({ ...state(docs, { attribute: wanted }), labels });
  assert.deepEqual(order({ name: 'dirty', value: true }), ['m1']);
  assert.deepEqual(order({ name: 'dirty', value: false }), ['m3']);
  assert.deepEqual(order({ name: 'lit', value: null }), ['m2', 'm1']);
  assert.deepEqual(order({ name: 'lit', value: 'dusk' }), ['m1']);
  assert.deepEqual(order({ name: 'gone', value: 'x' }), []);
});

test('a person’s label and review state count, not the engine’s', () => {
  const docs = { m1: doc(1, { class_id: 2, review: 'accepted' }) };
  assert.deepEqual(queueOrder(state(docs, { class_id: 2 })), ['m2', 'm1']);
  assert.deepEqual(queueOrder(state(docs, { review: 'open' })), ['m2', 'm3']);
});

test('a merged label counts as the label that replaces it', () => {
  const docs = { m1: doc(1, { class_id: 9 }) };
  assert.deepEqual(queueOrder(state(docs, { class_id: 2 })), ['m2', 'm1']);
  assert.deepEqual(queueOrder(state(docs, { class_id: 9 })), ['m2', 'm1'], 'a filter from before the merge');
  assert.deepEqual(queueOrder(state(docs, { text: 'stop' })), ['m2', 'm1']);
  assert.deepEqual(queueOrder(state(docs, { sort: 'class' })), ['m3', 'm1', 'm2']);
  assert.deepEqual(queueOrder(state(docs, { text: 'give way' })), ['m3'], 'an alias finds too');
});

test('attributes are found by name and value, of the whole track and of single frames', () => {
  const docs = {
    m1: doc(1, { attributes: { ground: 'red', dirty: true } }),
    m2: doc(2, { keys: { 12: keyFrame({ attributes: { dirty: false } }) } }),
  };
  /** @param {string} text */
  const found = (text) => queueOrder(state(docs, { text }));
  assert.deepEqual([found('dirty'), found('dirty=yes'), found('dirty=no ground'), found('ground=red')], [['m2', 'm1'], ['m1'], [], ['m1']]);
});

test('a track that an older version marked as no sign is a false positive', () => {
  const docs = { m1: doc(1, { not_a_sign: true }) };
  assert.deepEqual(queueOrder(state(docs, { review: 'rejected' })), ['m1']);
  assert.equal(queueCounts(trackEntries(state(docs).review.tracks, docs)).left, 2);
});

test('a track that is not in the set is filtered, found and uncertain as such', () => {
  const docs = { m1: doc(1, { class_id: NO_CLASS }) };
  assert.deepEqual(queueOrder(state(docs, { class_id: NO_CLASS })), ['m1']);
  assert.deepEqual(queueOrder(state(docs, { class_id: 1 })), ['m3']);
  assert.deepEqual(queueOrder(state(docs, { text: 'not set' })), ['m1']);
  assert.deepEqual(queueOrder(state(docs, { sort: 'class' })), ['m3', 'm2', 'm1']);
  const { tracks } = state().review;
  assert.equal(trackEntries(tracks, docs).find(({ key }) => key === 'm1')?.uncertainty, 1);
  const unread = { ...tracks, class_id: [null, 2, 1] };
  assert.equal(trackEntries(unread, { ...docs }).find(({ key }) => key === 'm1')?.uncertainty, 0.1, 'the engine has read none either');
});

test('deleted tracks are not in the queue, drawn tracks are', () => {
  const drawn = { ...blankDoc('hab'), class_id: 1, keys: { 5: keyFrame({ box: [0, 0, 9, 9] }) } };
  const docs = { m2: doc(2, { gone: true }), hab: drawn };
  assert.deepEqual(queueOrder(state(docs)), ['m3', 'm1', 'hab']);
  const entry = trackEntries(state(docs).review.tracks, docs).at(-1);
  assert.equal(entry?.track, null);
  assert.deepEqual([entry?.first, entry?.last], [5, 5]);
});

test('next and previous stop at the ends', () => {
  assert.equal(nextInQueue(state({}, {}, 'm2'), 1), 'm3');
  assert.equal(nextInQueue(state({}, {}, 'm1'), 1), null);
  assert.equal(nextInQueue(state({}, {}, 'm2'), -1), null);
  assert.equal(nextInQueue(state(), 1), 'm2');
  assert.equal(nextInQueue({ ...state(), review: null }, 1), null);
});

test('the message at the end of the queue counts the skipped tracks', () => {
  const decided = { m2: doc(2, { review: 'accepted' }), m3: doc(3, { review: 'rejected' }) };
  assert.equal(
    endOfQueue(state({}, {}, 'm1'), 1),
    'This is the end of the queue. 2 tracks before this one are still to be decided: press Esc, then J.',
  );
  assert.equal(
    endOfQueue(state({ m2: decided.m2 }, {}, 'm1'), 1),
    'This is the end of the queue. 1 track before this one is still to be decided: press Esc, then J.',
  );
  assert.equal(endOfQueue(state(decided, {}, 'm1'), 1), 'This is the end of the queue.');
  assert.equal(endOfQueue(state({}, {}, 'm2'), -1), 'This is the beginning of the queue. 2 tracks after this one are still to be decided.');
});

test('next goes to undecided tracks, previous to every track', () => {
  const decided = { m3: doc(3, { review: 'accepted' }) };
  assert.equal(nextInQueue(state(decided, {}, 'm2'), 1), 'm1', 'm3 has been accepted');
  assert.equal(nextInQueue(state(decided, {}, 'm1'), -1), 'm3');
  assert.equal(nextInQueue(state({ m3: doc(3, { review: 'needs_work' }) }, {}, 'm2'), 1), 'm3');
  assert.equal(
    nextInQueue(state({ ...decided, m1: doc(1, { review: 'rejected' }) }, {}, 'm3'), 1),
    null,
    'the undecided track comes before',
  );
  const all = { ...decided, m1: doc(1, { review: 'rejected' }), m2: doc(2, { review: 'accepted' }) };
  assert.equal(nextInQueue(state(all, {}, 'm2'), 1), 'm3', 'nothing is undecided: every track again');
  assert.equal(nextInQueue(state(all, { review: 'accepted' }, 'm2'), 1), 'm3', 'the filter selects them');
});

test('a track that the filter hides after accepting keeps its place', () => {
  const docs = { m3: doc(3, { review: 'accepted' }) };
  assert.equal(nextInQueue(state(docs, { review: 'open' }, 'm3'), 1), 'm1');
  assert.equal(nextInQueue(state(docs, { review: 'open' }, 'm3'), -1), 'm2');
});

test('open tracks and those that need work are undecided', () => {
  const docs = { m1: doc(1, { review: 'accepted' }), m2: doc(2, { review: 'needs_work' }) };
  assert.deepEqual(queueCounts(trackEntries(state(docs).review.tracks, docs)), {
    total: 3,
    open: 1,
    accepted: 1,
    rejected: 0,
    needs_work: 1,
    left: 2,
  });
});

test('tracks without a score come last, and the order is total', () => {
  const entries = trackEntries(state().review.tracks, {});
  entries[0].score = Number.NaN;
  assert.equal(queueOf(entries, { ...NO_FILTER, sort: 'score' }, LABELS).at(-1)?.key, 'm1');
});

test('a track that a person relabelled is uncertain until decided, and keeps its place', () => {
  for (const [change, uncertainty, reported] of /** @type {[object, number, string[]][]} */ ([
    [{ class_id: 2 }, 1, ['A person calls it something else than the engine.']],
    [{ class_id: 2, review: 'needs_work' }, 1, ['A person calls it something else than the engine.']],
    [{ class_id: 2, review: 'accepted' }, 0.1, []],
    [{ not_a_sign: true, review: 'rejected' }, 0.1, []],
    [{ class_id: 1 }, 0.1, []],
    [{}, 0.1, []],
  ])) {
    const docs = { m1: doc(1, change) };
    const entry = trackEntries(state(docs).review.tracks, docs)[0];
    assert.deepEqual([entry.key, entry.uncertainty, entry.reasons], ['m1', uncertainty, reported], JSON.stringify(change));
    assert.deepEqual(queueOrder(state(docs)), ['m2', 'm3', 'm1']);
    assert.deepEqual(queueOrder(state(docs, { least_uncertainty: 0.95 })), uncertainty === 1 ? ['m1'] : []);
  }
});

test('parts of a split track name the track of their reasons', () => {
  const secondPart = { ...blankDoc('hcd'), segments: [{ track: 2, first: 26, last: 30 }] };
  const docs = { m2: { ...doc(2, {}), segments: [{ track: 2, first: 20, last: 25 }] }, hcd: secondPart };
  const entries = trackEntries(state(docs).review.tracks, docs);
  for (const key of ['m2', 'hcd']) {
    const entry = entries.find((one) => one.key === key);
    assert.deepEqual([entry?.whole, entry?.reasons], [false, ['About #2 as the engine made it:', 'It is short: 11 frames.']], key);
  }
  assert.deepEqual(
    pluck(
      entries.filter((entry) => entry.whole),
      'key',
    ),
    ['m1', 'm3'],
  );
  const merged = {
    ...doc(1, {}),
    segments: [
      { track: 1, first: 30, last: 40 },
      { track: 3, first: 10, last: 20 },
    ],
  };
  const entry = trackEntries(state().review.tracks, { m1: merged })[0];
  assert.deepEqual([entry.whole, entry.reasons], [false, []], 'there is no reason for #1');
});

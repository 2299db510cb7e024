// @ts-check
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { detailColumns, lastIndexAt } from '../../../static/js/model/detail_columns.js';
import { countFlips, logDomain, logPosition, valueAtLogPosition } from '../../../static/js/model/gate_lane.js';
import { hashBits } from '../../../static/js/model/hash_bits.js';
import { packIntervals } from '../../../static/js/model/interval_packing.js';
import { CORRECTED, barAt, barName, buildDensity, buildLaneIndex, withVerdicts, levelFor } from '../../../static/js/model/lanes_lod.js';
import {
  countsAs,
  eventSentences,
  shortNumber,
  describeSource,
  describeSymmetry,
  symmetryHint,
  describeVerdict,
} from '../../../static/js/model/describe_events.js';
import { panBy, reveal, tickStep, timeLabel, toFrame, toX, zoomAround } from '../../../static/js/model/time_axis.js';
import { trackEntries } from '../../../static/js/model/track_entries.js';
import { documentLane } from '../../../static/js/model/track_lane.js';
import { blankDoc, emptyDoc } from '../../../static/js/model/documents.js';
import { SUB_LANES, shownLanes } from '../../../static/js/model/sub_lanes.js';
import { paintDetail } from '../../../static/js/views/lanes/detail_painter.js';
import { syntheticRun, syntheticLane } from '../harness/synthetic_run.js';
import { fakeContext } from '../canvas.js';
import { label } from '../labels.js';
import { pluck } from '../pluck.js';
import { keyFrame } from '../server_data.js';

const { tracks, lanes } = syntheticRun(20000, 800);
const entries = trackEntries(tracks, {});
const index = buildLaneIndex(entries, lanes, {});

test('bars of a row never overlap, and first-fit needs only as many rows as bars overlap', () => {
  const packed = packIntervals([0, 5, 20, 6], [10, 12, 30, 8], 2);
  assert.deepEqual([...packed.row], [0, 1, 0, 2]);
  for (let r = 0; r < index.rows; r += 1) {
    for (let b = index.rowStart[r] + 1; b < index.rowStart[r + 1]; b += 1) assert.ok(index.first[b] > index.last[b - 1]);
  }
});

test('every track has a bar, found by row and frame', () => {
  assert.equal(index.barOf.size, 800);
  for (const entry of entries) {
    const bar = index.barOf.get(entry.key) ?? -1;
    assert.equal(barAt(index, index.row[bar], entry.first, 0), bar);
    assert.equal(barAt(index, index.row[bar], entry.last + 0.9, 0), bar);
    assert.equal(barAt(index, index.row[bar], entry.first, 500), bar); // not its neighbour, which is near
  }
  assert.equal(barAt(index, index.rows, 5, 0), -1);
});

test('pieces of a bar cover it without a gap', () => {
  for (let b = 0; b < index.count; b += 1) {
    let at = index.first[b];
    for (let p = index.pieceStart[b]; p < index.pieceStart[b + 1]; p += 1) {
      assert.equal(index.pieceFirst[p], at);
      at = index.pieceLast[p] + 1;
    }
    assert.equal(at, index.last[b] + 1);
  }
});

test('key frames of a document are diamonds, and their boxes corrected pieces up to the next', () => {
  const key = keyFrame({ box: [0, 0, 9, 9] });
  const first = tracks.first[0];
  const doc = { ...emptyDoc({ track: 1, first, last: tracks.last[0] }), keys: { [first + 2]: key, [first + 8]: key } };
  const edited = buildLaneIndex(trackEntries(tracks, { m1: doc }), lanes, { m1: doc });
  const bar = edited.barOf.get('m1') ?? -1;
  assert.deepEqual([...edited.keyFrame.slice(edited.keyStart[bar], edited.keyStart[bar + 1])], [first + 2, first + 8]);
  const corrected = [];
  for (let p = edited.pieceStart[bar]; p < edited.pieceStart[bar + 1]; p += 1)
    if (edited.pieceSource[p] === CORRECTED) corrected.push([edited.pieceFirst[p], edited.pieceLast[p]]);
  assert.deepEqual(corrected, [
    [first + 2, first + 7],
    [first + 8, first + 8],
  ]);
});

test('a verdict or a label keeps the bars: the updated index equals a rebuilt one', () => {
  const span = { track: 1, first: tracks.first[0], last: tracks.last[0] };
  const accepted = { m1: { ...emptyDoc(span), review: /** @type {const} */ ('accepted'), class_id: 7 } };
  const relabelled = { m1: { ...structuredClone(accepted.m1), class_id: 9 } };
  const entriesOf = (/** @type {any} */ docs) => trackEntries(tracks, docs);
  const judged = withVerdicts(index, entriesOf(accepted), {}, accepted);
  assert.deepEqual(judged, buildLaneIndex(entriesOf(accepted), lanes, accepted));
  assert.ok(judged);
  assert.notDeepEqual(judged.review, index.review); // the old one is not written to
  assert.deepEqual(
    withVerdicts(judged, entriesOf(relabelled), accepted, relabelled),
    buildLaneIndex(entriesOf(relabelled), lanes, relabelled),
  );

  const none = { m1: { ...accepted.m1, not_a_sign: true } };
  const withoutSign = withVerdicts(judged, entriesOf(none), accepted, none);
  assert.equal(withoutSign?.review[withoutSign.barOf.get('m1') ?? -1], 2, 'as a false positive');
  assert.deepEqual(withoutSign, buildLaneIndex(entriesOf(none), lanes, none));

  const key = keyFrame({ box: [0, 0, 9, 9] });
  for (const other of /** @type {any[]} */ ([
    { m1: { ...accepted.m1, keys: { [span.first]: key } } },
    { m1: { ...accepted.m1, gone: true } },
    { m1: { ...accepted.m1, segments: [{ ...span, last: span.last - 3 }] } },
    { ...accepted, h1: emptyDoc({ track: 2, first: 3, last: 9 }) },
    {},
  ]))
    assert.equal(withVerdicts(judged, entriesOf(other), accepted, other), null);
});

test('every bar has a name, even without a class', () => {
  const labels = [label({ id: 14, name: 'stop' }), label({ id: 40_000, merged_into: 14 })];
  assert.deepEqual(
    [14, 3, -1, 40_000].map((id) => barName(labels, id)),
    ['stop', 'label 3', 'unlabelled', 'stop'],
  );
});

test('queue, lanes and inspector share one list of tracks', () => {
  const docs = { m1: emptyDoc({ track: 1, first: tracks.first[0], last: tracks.last[0] }) };
  assert.equal(trackEntries(tracks, docs), trackEntries(tracks, docs));
  assert.notEqual(trackEntries(tracks, docs), trackEntries(tracks, { ...docs }));
});

test('density: coarse levels keep the maximum of the joined values', () => {
  const density = buildDensity(entries, 20000);
  assert.ok(density.maxTracks >= 2);
  for (let level = 1; level < density.tracks.length; level += 1) assert.equal(Math.max(...density.tracks[level]), density.maxTracks);
  assert.equal(levelFor(density, 1), 0);
  assert.equal(levelFor(density, 1e9), density.tracks.length - 1);
});

test('zoom keeps the frame under the pointer, and the span within the drive', () => {
  const span = zoomAround({ first: 100, last: 300 }, 150, 0.5, 1000);
  assert.ok(Math.abs(toX(span, 150, 800) - toX({ first: 100, last: 300 }, 150, 800)) < 1e-9);
  assert.deepEqual(zoomAround(span, 150, 1e9, 1000), { first: 0, last: 1000 });
  assert.equal(zoomAround(span, 150, 1e-9, 1000).last - zoomAround(span, 150, 1e-9, 1000).first, 8);
  assert.deepEqual(panBy({ first: 100, last: 300 }, 1e6, 1000), { first: 800, last: 1000 });
  assert.equal(toFrame(span, toX(span, 123, 800), 800), 123);
  const same = { first: 0, last: 10 };
  assert.equal(reveal(same, 9, 100), same);
  const moved = reveal(same, 50, 100);
  assert.ok(moved.first <= 50 && moved.last >= 51);
});

test('ticks are round, labels have the digits that they need', () => {
  assert.equal(tickStep(1, 100), 100);
  assert.equal(tickStep(1.1, 100), 200);
  assert.equal(timeLabel(3723.4, 10), '1:02:03');
  assert.equal(timeLabel(59.99, 0.1), '1:00.0');
  assert.equal(timeLabel(0.04, 0.04), '0:00.04');
});

test('a dragged tau flips exactly the verdicts between both thresholds', () => {
  const lane = syntheticLane(tracks, 0);
  lane.l_positive = [null, 5, 12, 14.9, 15, 80, 1e9];
  lane.confident = [null, true, true, true, false, false, false];
  lane.frame = lane.frame.slice(0, 7);
  assert.deepEqual(countFlips(lane, 15), { verdicts: 6, toConfident: 0, toRejected: 0, total: 0 });
  assert.deepEqual(countFlips(lane, 10), { verdicts: 6, toConfident: 0, toRejected: 2, total: 2 });
  assert.deepEqual(countFlips(lane, 81), { verdicts: 6, toConfident: 2, toRejected: 0, total: 2 });
  const domain = logDomain(lane, 15);
  assert.deepEqual(domain, { low: 1, high: 1e5 });
  assert.equal(logPosition(0, domain), 0);
  assert.equal(valueAtLogPosition(logPosition(15, domain), domain), 15);
});

test('columns: a step that did not take place is NaN, votes are cumulative', () => {
  const lane = syntheticLane(tracks, 1);
  const columns = detailColumns(lane);
  assert.ok(Number.isNaN(columns.series.l_positive[0]));
  assert.ok(columns.votes[1] > columns.votes[0]);
  assert.equal(lastIndexAt(columns.frame, lane.frame[3]), 3);
  assert.equal(lastIndexAt(columns.frame, lane.frame[0] - 1), -1);
});

test('votes are painted in the frames of the track only, not in the gap of a merged one', () => {
  const [before, after] = [
    syntheticLane({ ...tracks, id: [2], first: [83], last: [111] }, 0),
    syntheticLane({ ...tracks, id: [6], first: [175], last: [193] }, 0),
  ];
  const doc = {
    ...blankDoc('m2'),
    segments: [
      { track: 2, first: 83, last: 111 },
      { track: 6, first: 175, last: 193 },
    ],
  };
  const merged = documentLane('m2', doc, { 2: before, 6: after });
  assert.ok(merged);
  /** @type {[number, number][]} */
  const painted = [];
  const ctx = fakeContext((name, [x, , width]) => {
    if (name === 'rect') painted.push([x, x + width]);
  });
  const palette = { unit: 1, colour: {}, series: ['#000'], smallFont: '' };
  // ten px a frame
  paintDetail(
    ctx,
    detailColumns(merged.lane),
    { width: 2000, span: { first: 0, last: 200 }, tau: 15, lanes: SUB_LANES },
    /** @type {any} */ (palette),
  );
  const frames = new Set(painted.flatMap(([left, right]) => [Math.floor(left / 10), Math.floor((right - 1) / 10)]));
  assert.deepEqual(
    [...frames].sort((a, b) => a - b),
    merged.lane.frame,
  );
});

test('events are sentences without the name of the track', () => {
  const lane = syntheticLane(tracks, 2);
  lane.events = [
    {
      frame: lane.frame[5],
      kind: 'relocalised',
      text: `Prediction of track ${lane.id} rejected, L = 38.2 > 15, symmetry 0.21 is low; relocalised 6 px left.`,
    },
    {
      frame: lane.frame[6],
      kind: 'relocalised',
      text: `Track ${lane.id} has had no detection for 3 frames; a window like it is 6 px left.`,
    },
    { frame: lane.frame[8], kind: 'relabelled', text: `Track ${lane.id} is now 'yield' with 60 % of the votes, no longer 'stop'.` },
  ];
  lane.confident.fill(true);
  lane.confident[5] = false;
  lane.confident[7] = false;
  lane.l_positive[7] = 40;
  lane.symmetry[7] = 5;
  lane.symmetry_magnitude[7] = 0.2;
  lane.hash_distance[7] = 4;
  lane.position_distance[7] = 2;
  lane.source[7] = 1;
  const sentences = eventSentences(lane);
  assert.deepEqual(pluck(sentences, 'kind'), ['born', 'relocalised', 'relocalised', 'rejected', 'relabelled', 'ended']);
  assert.equal(sentences[1].text, 'prediction rejected, L = 38.2 > 15, symmetry 0.21 is low; relocalised 6 px left');
  assert.equal(sentences[2].text, 'no detection for 3 frames; a window like it is 6 px left');
  assert.equal(sentences[4].text, "now 'yield' with 60 % of the votes, no longer 'stop'");
  assert.equal(sentences[3].text, 'prediction rejected, L = 40 > 15, symmetry 0.2 is low; nothing better was found near it');
  assert.equal(shortNumber(1e9), 'very large');
  assert.equal(shortNumber(null), '–');
});

test('the end and the beginning are reported once, and no sentence names the track', () => {
  const lane = syntheticLane(tracks, 2);
  lane.confident.fill(true);
  const end = lane.frame.at(-1) ?? 0;
  lane.events = [
    { frame: lane.frame[0], kind: 'born', text: `Track ${lane.id} starts from a detection with score 2.04.` },
    { frame: lane.frame[2], kind: 'confirmed', text: `Track ${lane.id} is confirmed by 3 detections in its last 8 frames.` },
    { frame: end + 1, kind: 'died', text: `Track ${lane.id} ended: only 27 % of its box is in view.` },
  ];
  assert.deepEqual(
    eventSentences(lane)
      .filter(({ kind }) => kind !== 'unlearned')
      .map(({ text }) => text),
    ['starts from a detection with score 2.04', 'confirmed by 3 detections in its last 8 frames', 'ended: only 27 % of its box is in view'],
  );
});

test('a frame says where its box comes from, and its verdict with all factors', () => {
  const lane = syntheticLane(tracks, 2);
  Object.assign(lane, {
    tau: 15,
    score: [3.86, null, 4],
    raw_score: [3, null, 4.5],
    source: [0, 2, 0],
    decision: [null, 0.5, null],
    probability: [null, 0.63, null],
  });
  Object.assign(lane, {
    confident: [null, false, true],
    l_positive: [null, 18.22, 9],
    symmetry: [null, 1.6667, 2],
    hash_distance: [null, 20, 4],
    position_distance: [null, 0.5466, 0.5],
  });
  assert.equal(describeSource(lane, 0), 'Score 3.86 = detector 3 + prior 0.86.');
  assert.equal(describeSource(lane, 2), 'Score 4 = detector 4.5 - prior 0.5.');
  assert.equal(describeSource(lane, 1), 'Re-detected by the online detector: f = 0.5, probability 0.63.');
  assert.equal(describeVerdict(lane, 0), null);
  assert.equal(
    describeVerdict(lane, 1),
    'Prediction rejected: gate score 18.2 = 1.67 (symmetry) × 20 (appearance distance, bits) × 0.547 (position), > tau 15.',
  );
  assert.equal(
    describeVerdict(lane, 2),
    'Prediction confident: gate score 9 < tau 15, from 2 (symmetry), 4 (appearance distance, bits), 0.5 (position).',
  );
});

test('the first factor is explained with the run’s own floor', () => {
  const lane = syntheticLane(tracks, 2);
  Object.assign(lane, { symmetry_floor: 0.6, symmetry: [null, 1.6667, 1.4085], symmetry_magnitude: [null, 0.239, 0.71] });
  assert.equal(describeSymmetry(lane, 0), null);
  assert.equal(
    describeSymmetry(lane, 1),
    'The crop’s mirror symmetry is 0.239, which counts as 0.6 (symmetry_floor): the factor is 1 / 0.6 = 1.67.',
  );
  assert.equal(describeSymmetry(lane, 2), 'The crop’s mirror symmetry is 0.71: the factor is 1 / 0.71 = 1.41.');
  lane.symmetry_floor = 0.2;
  lane.symmetry[1] = 1 / 0.239;
  assert.equal(describeSymmetry(lane, 1), 'The crop’s mirror symmetry is 0.239: the factor is 1 / 0.239 = 4.18.');
  assert.equal(countsAs(0.239, 0.6), ', which counts as 0.6 (symmetry_floor)');
  assert.equal(countsAs(0.6, 0.6), '');
  assert.match(symmetryHint(0.25), /at least 0\.25 \(symmetry_floor\)/);
});

test('hash bits, the highest first', () => {
  assert.deepEqual(
    [...hashBits('8000000000000001')].flatMap((bit, i) => (bit ? [i] : [])),
    [0, 63],
  );
  assert.throws(() => hashBits('12'), RangeError);
});

test('folded lanes show the chosen lane, or the gate if the name is unknown', () => {
  assert.deepEqual(pluck(shownLanes({ folded: true, lane: 'votes' }), 'id'), ['votes']);
  assert.deepEqual(pluck(shownLanes({ folded: true, lane: 'gone' }), 'id'), ['gate']);
  assert.equal(shownLanes({ folded: false, lane: 'votes' }).length, SUB_LANES.length);
});

// @ts-check
/** What the engine calls signs that the label set has no label for. */
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { applyCommand } from '../../../static/js/model/commands.js';
import { blankDoc } from '../../../static/js/model/documents.js';
import { engineName } from '../../../static/js/model/labels.js';
import { describeLabels } from '../../../static/js/model/describe_corrections.js';
import { NO_FILTER, queueOf } from '../../../static/js/model/queue.js';
import { trackEntries } from '../../../static/js/model/track_entries.js';
import { documentLane } from '../../../static/js/model/track_lane.js';
import { shownTracks } from '../../../static/js/review/shown_tracks.js';
import { describeCell } from '../../../static/js/views/compare_confusion.js';
import { syntheticRun, syntheticLane } from '../harness/synthetic_run.js';
import { label } from '../labels.js';
import { pluck } from '../pluck.js';

const labels = [label({ id: 3, name: 'stop' })];
const person = { author: 'a', time: '' };

test('the engine’s name is shown only if the set has no such label', () => {
  assert.equal(engineName(labels, -1, 'bus stop'), 'bus stop (not in the set)');
  assert.equal(engineName(labels, -1, null), 'not in the set');
  assert.equal(engineName(labels, 3, null), 'stop');
  assert.equal(describeCell({ reference: 3, candidate: -10 }, labels, { '-10': 'bus stop' }), 'stop, read as bus stop');
});

test('in queue and picture, until a person gives a label', () => {
  const { tracks } = syntheticRun(200, 2);
  const own = { ...tracks, class_id: [-1, 3], word: ['Bus stop', null] };
  const [first, second] = own.id;
  const key = `m${first}`;
  const words = () => trackEntries(own, docs).map(({ word }) => word);
  /** @type {Record<string, import('../../../static/js/types.js').TrackDoc>} */
  let docs = {};
  assert.deepEqual(words(), ['Bus stop', null]);
  const filter = { ...NO_FILTER, text: 'bus' };
  assert.deepEqual(pluck(queueOf(trackEntries(own, docs), filter, labels), 'key'), [key]);
  const review = () =>
    /** @type {any} */ ({
      frame: own.first[0],
      docs,
      tracks: own,
      following: null,
      overlays: {
        [own.first[0]]: {
          tracks: [
            { id: first, state: 'confirmed', box: [0, 0, 9, 9], class_id: -1, word: 'Bus stop' },
            { id: second, state: 'confirmed', box: [20, 0, 29, 9], class_id: 3, word: null },
          ],
        },
      },
    });
  assert.deepEqual(pluck(shownTracks(review()), 'word'), ['Bus stop', null]);
  const spans = [{ track: first, first: own.first[0], last: own.last[0] }];
  ({ docs } = applyCommand(docs, { name: 'set_occluded', key, frame: own.first[0], value: true, spans }, person));
  assert.equal(shownTracks(review()).find((one) => one.key === key)?.word, 'Bus stop', 'its label is the engine’s still');
  ({ docs } = applyCommand(docs, { name: 'relabel_track', key, frame: 0, class_id: -1 }, person));
  assert.deepEqual([words(), shownTracks(review()).find((one) => one.key === key)?.word], [[null, null], null]);
  assert.equal(
    describeLabels(docs[key], -1, () => 'not in the set', 'Bus stop'),
    'Label set by a person; the engine reads Bus stop.',
  );
});

test('two of the engine’s words are two lines of a joined lane', () => {
  const { tracks } = syntheticRun(1000, 1);
  const base = syntheticLane({ ...tracks, id: [7], first: [10], last: [11] }, 0);
  /** @type {import('../../../static/js/types.js').TrackLane} */
  const lane = {
    ...base,
    classes: [-1, -1, 3],
    words: ['bus stop', 'tram stop', null],
    probabilities: [
      [0.6, 0.3, 0.1],
      [0.2, 0.7, 0.1],
    ],
    votes: [
      [0.6, 0.3, 0.1],
      [0.4, 0.5, 0.1],
    ],
    top: [-1, -1],
    top_word: ['bus stop', 'tram stop'],
    top_probability: [0.6, 0.7],
    weight: [1, 1],
  };
  const found = documentLane('m7', { ...blankDoc('m7'), segments: [{ track: 7, first: 11, last: 11 }] }, { 7: lane });
  assert.deepEqual(
    [found?.lane.words, found?.lane.classes],
    [
      ['tram stop', 'bus stop', null],
      [-1, -1, 3],
    ],
  );
  assert.deepEqual([found?.reading?.word, found?.reading?.runner_up_word, found?.reading?.share], ['tram stop', 'bus stop', 0.7]);
});

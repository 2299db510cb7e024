// @ts-check
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { formatRoute, parseRoute } from '../../../static/js/model/route.js';
import {
  formatSearch,
  hasSecondaryFilter,
  describeMatchedLabels,
  NO_SEARCH,
  parseSearch,
  selectTracks,
  withChanged,
} from '../../../static/js/model/search.js';
import { rowsOf } from '../pluck.js';

/** @param {string} key @param {object} [further] @returns {any} */
const track = (key, further = {}) => ({ run: 'r', key, state: 'open', ...further });

test('filters survive a round trip through the address', () => {
  const filters = { ...NO_SEARCH, label: ['C,3a', 'stop'], uncertainty_min: '0.3', text: 'bent & old', runs: 'all' };
  const query = formatSearch(filters);
  assert.equal(query, 'label=C%2C3a&label=stop&uncertainty_min=0.3&text=bent%20%26%20old&runs=all');
  assert.deepEqual(parseSearch(query), filters);
  assert.equal(formatSearch(NO_SEARCH), '');
  assert.deepEqual(parseSearch('text=bent+old&video=50%').text, 'bent old');
  assert.equal(parseSearch('video=50%').video, '50%');
  assert.deepEqual(parseSearch('attribute=dirty=yes').attribute, ['dirty=yes']);
});

test('unknown filters are ignored, and duplicates removed', () => {
  assert.equal(formatSearch(parseSearch('colour=red&label=60&label=60&sort=uncertainty&text=')), 'label=60');
  assert.deepEqual(parseRoute('#/search?label=60&x=1'), { screen: 'search', query: 'label=60' });
  assert.equal(formatRoute({ screen: 'search', query: 'label=60' }), '#/search?label=60');
  assert.equal(formatRoute(parseRoute('#/search')), '#/search');
});

test('the second row is there for its filters', () => {
  assert.equal(hasSecondaryFilter({ ...NO_SEARCH, label: ['stop'] }), false);
  assert.equal(hasSecondaryFilter({ ...NO_SEARCH, tag: ['night'] }), true);
});

test('the labels that words mean are named, unless the words are their names', () => {
  const labels = ['stop', 'pedestrians', 'pedestrian crossing', 'stop'].map((name) => ({ name }));
  assert.equal(describeMatchedLabels(labels, ['stop', 'ped']), 'Labels: stop, pedestrians, pedestrian crossing.');
  assert.equal(describeMatchedLabels(labels, ['ped'], 2), 'Labels: stop, pedestrians and 1 more.');
  assert.equal(describeMatchedLabels(labels.slice(0, 1), ['#14']), 'Label: stop.');
  assert.equal(describeMatchedLabels(labels.slice(0, 1), ['STOP']), '');
  assert.equal(describeMatchedLabels([], []), '');
});

test('click, toggle and range select', () => {
  const tracks = ['a', 'b', 'c', 'd'].map((key) => track(key));
  const one = selectTracks(new Set(), tracks, 0, 1, 'only');
  assert.deepEqual([...one], ['r/b']);
  assert.deepEqual([...selectTracks(one, tracks, 1, 3, 'range')], ['r/b', 'r/c', 'r/d']);
  assert.deepEqual([...selectTracks(one, tracks, 1, 0, 'range')], ['r/a', 'r/b']);
  assert.deepEqual([...selectTracks(one, tracks, 1, 3, 'toggle')], ['r/b', 'r/d']);
  assert.deepEqual([...selectTracks(one, tracks, 1, 1, 'toggle')], []);
  assert.deepEqual([...selectTracks(one, tracks, 1, 9, 'only')], ['r/b']);
});

test('changed tracks keep their positions', () => {
  const tracks = [track('a'), track('b')];
  const now = withChanged(tracks, [track('b', { state: 'accepted' }), track('z')]);
  assert.deepEqual(rowsOf(now, 'key', 'state'), [
    ['a', 'open'],
    ['b', 'accepted'],
  ]);
});

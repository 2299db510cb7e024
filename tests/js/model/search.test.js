// @ts-check
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { formatRoute, parseRoute } from '../../../static/js/model/route.js';
import { formatSearch, hasFurther, meantWords, NO_SEARCH, parseSearch, select, withChanged } from '../../../static/js/model/search.js';

/** @param {string} key @param {object} [further] @returns {any} */
const track = (key, further = {}) => ({ run: 'r', key, state: 'open', ...further });

test('an address is a question, and comes back as it was', () => {
  const filters = { ...NO_SEARCH, label: ['C,3a', 'stop'], uncertainty_min: '0.3', text: 'bent & old', runs: 'all' };
  const query = formatSearch(filters);
  assert.equal(query, 'label=C%2C3a&label=stop&uncertainty_min=0.3&text=bent%20%26%20old&runs=all');
  assert.deepEqual(parseSearch(query), filters);
  assert.equal(formatSearch(NO_SEARCH), '');
  assert.deepEqual(parseSearch('text=bent+old&video=50%').text, 'bent old');
  assert.equal(parseSearch('video=50%').video, '50%');
  assert.deepEqual(parseSearch('attribute=dirty=yes').attribute, ['dirty=yes']);
});

test('what an address does not know is left out, and twice the same is once', () => {
  assert.equal(formatSearch(parseSearch('colour=red&label=60&label=60&sort=uncertainty&text=')), 'label=60');
  assert.deepEqual(parseRoute('#/search?label=60&x=1'), { screen: 'search', query: 'label=60' });
  assert.equal(formatRoute({ screen: 'search', query: 'label=60' }), '#/search?label=60');
  assert.equal(formatRoute(parseRoute('#/search')), '#/search');
});

test('the second row is there for its filters', () => {
  assert.equal(hasFurther({ ...NO_SEARCH, label: ['stop'] }), false);
  assert.equal(hasFurther({ ...NO_SEARCH, tag: ['night'] }), true);
});

test('the labels that words mean are named, unless the words are their names', () => {
  const labels = ['stop', 'pedestrians', 'pedestrian crossing', 'stop'].map((name) => ({ name }));
  assert.equal(meantWords(labels, ['stop', 'ped']), 'Labels: stop, pedestrians, pedestrian crossing.');
  assert.equal(meantWords(labels, ['ped'], 2), 'Labels: stop, pedestrians and 1 more.');
  assert.equal(meantWords(labels.slice(0, 1), ['#14']), 'Label: stop.');
  assert.equal(meantWords(labels.slice(0, 1), ['STOP']), '');
  assert.equal(meantWords([], []), '');
});

test('click, toggle and range select', () => {
  const tracks = ['a', 'b', 'c', 'd'].map((key) => track(key));
  const one = select(new Set(), tracks, 0, 1, 'only');
  assert.deepEqual([...one], ['r/b']);
  assert.deepEqual([...select(one, tracks, 1, 3, 'range')], ['r/b', 'r/c', 'r/d']);
  assert.deepEqual([...select(one, tracks, 1, 0, 'range')], ['r/a', 'r/b']);
  assert.deepEqual([...select(one, tracks, 1, 3, 'toggle')], ['r/b', 'r/d']);
  assert.deepEqual([...select(one, tracks, 1, 1, 'toggle')], []);
  assert.deepEqual([...select(one, tracks, 1, 9, 'only')], ['r/b']);
});

test('what an action has changed stays in its place', () => {
  const tracks = [track('a'), track('b')];
  const now = withChanged(tracks, [track('b', { state: 'accepted' }), track('z')]);
  assert.deepEqual(
    now.map(({ key, state }) => [key, state]),
    [
      ['a', 'open'],
      ['b', 'accepted'],
    ],
  );
});

// @ts-check
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { formatRoute, parseRoute, currentAddress, isSameView, runAddress } from '../../../static/js/model/route.js';
import * as actions from '../../../static/js/store/actions/page.js';
import { initialState } from '../../../static/js/store/initial.js';
import { pluck, rowsOf } from '../pluck.js';

/** @param {string} id @param {object} [more] */
const video = (id, more = {}) => /** @type {any} */ ({ id, name: id, ...more });
/** @param {string} id @param {object} [more] */
const run = (id, more = {}) => /** @type {any} */ ({ id, video_id: 'v', ...more });

test('a changed video takes its place, a new one comes first, an unloaded list stays unloaded', () => {
  assert.equal(actions.putVideo(initialState(), video('a')).videos, null);
  const state = actions.setVideos(initialState(), [video('a'), video('b')]);
  assert.deepEqual(rowsOf(actions.putVideo(state, video('b', { state: 'ready' })).videos, 'id', 'state'), [
    ['a', undefined],
    ['b', 'ready'],
  ]);
  assert.deepEqual(pluck(actions.putVideo(state, video('c')).videos, 'id'), ['c', 'a', 'b']);
});

test('runs of a video that is not loaded are not made up from one event', () => {
  const empty = initialState();
  assert.equal(actions.putRun(empty, run('r')), empty);
  const state = actions.setRuns(empty, 'v', [run('r')]);
  assert.deepEqual(pluck(actions.putRun(state, run('s')).runs.v, 'id'), ['s', 'r']);
  assert.deepEqual(actions.dropRun(state, 'r').runs.v, []);
  assert.deepEqual(actions.dropVideo(actions.setVideos(state, [video('v')]), 'v').runs, {});
});

test('the assignments of a removed video go with it', () => {
  const assignment = (/** @type {number} */ id, /** @type {string} */ video_id) => /** @type {any} */ ({ id, video_id, revision: 1 });
  const state = { ...actions.setVideos(initialState(), [video('v'), video('w')]), assignments: [assignment(1, 'v'), assignment(2, 'w')] };
  assert.deepEqual(pluck(actions.dropVideo(state, 'v').assignments, 'id'), [2]);
});

test('a banner replaces the one of its id; what changes nothing is the same state', () => {
  const both = actions.showBanner(actions.showBanner(initialState(), { id: 'x', tone: 'info', text: '1' }), {
    id: 'z',
    tone: 'info',
    text: '3',
  });
  const state = actions.showBanner(both, { id: 'x', tone: 'error', text: '2' });
  assert.deepEqual(pluck(state.banners, 'text'), ['2', '3'], 'in its place');
  assert.equal(actions.hideBanner(state, 'y'), state);
  assert.equal(actions.setConnection(state, 'online'), state);
  assert.equal(actions.closeDialog(state), state);
});

test('routes survive the way into the address and back', () => {
  const id = 'a'.repeat(64);
  const other = 'b'.repeat(32);
  for (const route of /** @type {import('../../../static/js/state-types.js').Route[]} */ ([
    { screen: 'library' },
    { screen: 'review', video: id, run: null, frame: null, track: null },
    { screen: 'review', video: id, run: other, frame: 0, track: 'h-1/ä?&' },
    { screen: 'compare', a: `run:${other}`, b: `truth:${other}` },
    { screen: 'models' },
    { screen: 'files' },
  ]))
    assert.deepEqual(parseRoute(formatRoute(route)), route);
  for (const hash of ['', '#', '#/review/xyz', '#/compare?a=run:1', '#/review/%', '#/compare?a=%E0%A4%A', '#/nothing', '#/models/x'])
    assert.deepEqual(parseRoute(hash), { screen: 'library' }, hash);
});

test('another video or run is another place, another frame or track of it is not', () => {
  const [video, run, other] = ['a'.repeat(64), 'b'.repeat(32), 'c'.repeat(32)];
  const at = parseRoute(`#/review/${video}/${run}?frame=3&track=m1`);
  /** @param {string} hash @param {string|null} [shown] @param {import('../../../static/js/state-types.js').Route} [before] */
  const same = (hash, shown = run, before = at) => isSameView(before, parseRoute(hash), shown);
  assert.ok(same(`#/review/${video}/${run}?frame=9&track=m2`));
  assert.ok(!same(`#/review/${'d'.repeat(64)}/${run}`));
  assert.ok(!same(`#/review/${video}/${other}`));
  assert.ok(!same(`#/review/${video}/-`), 'the newest may be another one');
  const newest = parseRoute(`#/review/${video}/-`);
  assert.ok(same(`#/review/${video}/-`, run, newest));
  assert.ok(same(`#/review/${video}/${run}`, run, newest), 'the address only says by now which one is shown');
  assert.ok(!same(`#/review/${video}/${other}`, run, newest));
  assert.ok(!same('#/files'));
  assert.ok(same('#/files', null, parseRoute('#/files')));
});

test('the address says where one is, and never the run that is being left', () => {
  const [id, mine, next] = ['a'.repeat(64), 'b'.repeat(32), 'c'.repeat(32)];
  const review = { video: video(id), timebase: {}, run: run(mine), tracks: {}, frame: 7, selected: 'm1', playing: false };
  /** @param {string} hash @param {object} [more] */
  const place = (hash, more = {}) => currentAddress({ route: parseRoute(hash), review: /** @type {any} */ ({ ...review, ...more }) });
  assert.equal(place(`#/review/${id}/-?frame=3`), `#/review/${id}/${mine}?frame=7&track=m1`);
  assert.equal(place(`#/review/${id}/${next}?frame=3`), null, 'it is being opened');
  assert.equal(place(`#/review/${id}/${next}?frame=3`, { run: null, selected: null }), `#/review/${id}/${next}?frame=7`, 'it is not there');
  assert.equal(
    place(`#/review/${id}/${mine}?frame=3&track=m9`, { tracks: null, selected: null }),
    `#/review/${id}/${mine}?frame=7&track=m9`,
  );
  assert.equal(place(`#/review/${id}/${mine}?frame=3&track=m9`, { selected: null }), `#/review/${id}/${mine}?frame=7`);
  for (const more of [{ playing: true }, { timebase: null }, { video: video('other') }])
    assert.equal(place(`#/review/${id}/${mine}`, more), null);
  assert.equal(place('#/files'), null);
});

test('another run of the video opens at the frame on the screen', () => {
  const [id, other, next] = ['a'.repeat(64), 'd'.repeat(64), 'c'.repeat(32)];
  const review = { video: video(id), timebase: {}, frame: 7 };
  /** @param {string} hash @param {string} of @param {object} [more] */
  const opened = (hash, of, more = {}) =>
    runAddress({ route: parseRoute(hash), review: /** @type {any} */ ({ ...review, ...more }) }, of, next);
  assert.equal(opened(`#/review/${id}/-?frame=3&track=m1`, id), `#/review/${id}/${next}?frame=7`);
  assert.equal(opened(`#/review/${id}/-?frame=3`, id, { timebase: null }), `#/review/${id}/${next}?frame=3`, 'it is being opened');
  assert.equal(opened(`#/review/${id}/-?frame=3`, other), `#/review/${other}/${next}`);
  assert.equal(opened('#/', id), `#/review/${id}/${next}`);
});

test('files and versions take their place, and leave it', () => {
  const made = (/** @type {string} */ id, more = {}) => /** @type {any} */ ({ id, state: 'queued', active: false, ...more });
  assert.equal(actions.putOutput(initialState(), made('a')).outputs, null);
  let state = actions.setOutputs(initialState(), [made('a')]);
  state = actions.putOutput(actions.putOutput(state, made('b')), made('a', { state: 'complete' }));
  assert.deepEqual(rowsOf(state.outputs, 'id', 'state'), [
    ['b', 'queued'],
    ['a', 'complete'],
  ]);
  assert.deepEqual(pluck(actions.dropOutputOrModel(state, 'b').outputs, 'id'), ['a']);
  assert.equal(actions.dropOutputOrModel(state, 'x'), state);
});

test('exactly one version is in use, the shipped one where no other is', () => {
  const version = (/** @type {string} */ id, active = false) => /** @type {any} */ ({ id, active });
  const used = (/** @type {any} */ state) =>
    state.models.filter((/** @type {any} */ one) => one.active).map((/** @type {any} */ one) => one.id);
  let state = actions.setModels(initialState(), [version('b'), version('a'), version('shipped', true)]);
  state = actions.putModel(state, version('a', true));
  assert.deepEqual(used(state), ['a']);
  state = actions.putModel(state, version('b', true));
  assert.deepEqual(used(state), ['b']);
  state = actions.putModel(state, version('b', false));
  assert.deepEqual(used(state), ['shipped']);
});

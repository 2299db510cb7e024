// @ts-check
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { ApiError } from '../../../static/js/api/errors.js';
import { createLabelSets, labelSetKey } from '../../../static/js/editing/label_sets.js';
import { setLabelSets } from '../../../static/js/store/actions/page.js';
import { initialReview, initialState } from '../../../static/js/store/initial.js';
import { createStore } from '../../../static/js/store/store.js';
import { label } from '../labels.js';
import { pluck } from '../pluck.js';

const head = (/** @type {string} */ key, /** @type {number} */ version, standard = false) => ({
  key,
  name: key,
  version,
  labels: 1,
  default: standard,
  shipped: true,
});

const settle = () => new Promise((resolve) => setTimeout(resolve));

/** A server with two sets; `vienna` is the video's own where it has one. */
function createFixture() {
  const store = createStore(initialState());
  /** @type {string[]} */ const messages = [];
  /** @type {{version: number, labels: import('../../../static/js/types.js').Label[], requests: (string|null)[], refusal: Error|null, outage: Error|null, heard: Promise<void>}} */
  const server = {
    version: 1,
    labels: [label({ id: 0, name: 'stop' })],
    requests: [],
    refusal: null,
    outage: null,
    heard: Promise.resolve(),
  };
  const api = /** @type {any} */ ({
    labelSets: async () => (server.outage ? Promise.reject(server.outage) : [head('gtsrb-43', server.version, true), head('vienna', 1)]),
    labels: async (/** @type {string|null} */ video) => (
      server.requests.push(video),
      video ? [label({ id: 5, name: 'boar' })] : server.labels
    ),
    labelHistory: async () => [{ version: server.version, author: 'Anna', created: '', sentence: 'Added ‘no parking’.', undoes: null }],
    changeLabels: async (/** @type {string} */ set, /** @type {string} */ author, /** @type {any} */ change) => {
      if (server.refusal) throw server.refusal;
      server.version += 1;
      server.labels = [...server.labels, label({ id: server.version, name: change.name })];
      return { version: server.version, label: server.labels.at(-1), sentence: `${author} in ${set}` };
    },
    importLabels: async () => {
      await settle();
      server.version += 1;
      server.heard = receive(); // the event overtakes the answer
      await settle();
      return { version: server.version };
    },
  });
  /** @type {number[]} */ const changes = [];
  const sets = createLabelSets({
    store,
    api,
    author: () => 'Ben',
    notify: (text) => void messages.push(text),
    onChanged: () => void changes.push(1),
  });
  const receive = (version = server.version, subject = 'gtsrb-43') => sets.receive({ seq: 1, kind: 'labels', subject, data: { version } });
  return { store, server, sets, said: messages, turned: changes, receive };
}

test('labels are those of the video’s own set while it is on the screen', async () => {
  const { store, sets, server } = createFixture();
  await sets.reload();
  assert.deepEqual([labelSetKey(store.get()), store.get().labels[0].name], ['gtsrb-43', 'stop']);
  const video = /** @type {any} */ ({ id: 'v', label_set: 'vienna', frames: 9 });
  store.dispatch((state) => ({ ...state, review: initialReview(video) }));
  sets.sync();
  sets.sync();
  await settle();
  assert.deepEqual([labelSetKey(store.get()), store.get().labels[0].name, server.requests], ['vienna', 'boar', [null, 'v']]);
  store.dispatch((state) => ({ ...state, review: null }));
  sets.sync();
  await settle();
  assert.equal(store.get().labels[0].name, 'stop');
});

test('tracks are reloaded if their video uses another set or version', async () => {
  const { store, server, sets, turned, receive } = createFixture();
  await sets.reload();
  const open = (/** @type {any} */ video) => {
    store.dispatch((state) => ({ ...state, review: initialReview(video) }));
    sets.sync();
  };
  open({ id: 'v', label_set: null, frames: 9 });
  await settle();
  assert.equal(turned.length, 0, 'a video is opened with the labels of its own set');
  server.version = 2;
  await receive();
  assert.equal(turned.length, 1);
  store.dispatch((state) => ({ ...state, review: initialReview(/** @type {any} */ ({ id: 'v', label_set: 'vienna', frames: 9 })) }));
  sets.sync();
  await settle();
  assert.equal(turned.length, 2);
  open({ id: 'w', label_set: null, frames: 9 });
  await settle();
  assert.equal(turned.length, 2);
});

test('a change is in the store once it is made, and is no news to the page that made it', async () => {
  const { store, sets, said, receive } = createFixture();
  await sets.reload();
  const change = sets.change({ type: 'add', name: 'no parking' });
  await Promise.all([change, receive(2)]);
  assert.deepEqual(pluck(store.get().labels, 'name'), ['stop', 'no parking']);
  assert.deepEqual([(await change).sentence, said], ['Ben in gtsrb-43', []]);
});

test('a file of labels is no news to the page that imported it', async () => {
  const { sets, said, server } = createFixture();
  await sets.reload();
  await sets.importFile('gtsrb-43', /** @type {any} */ ({ name: 'labels.json' }), false);
  await server.heard;
  assert.deepEqual(said, []);
});

test('an event loads the labels after a change whose answer was lost', async () => {
  const { store, sets, server, said, receive } = createFixture();
  await sets.reload();
  server.outage = new ApiError(0, 'offline', 'The server cannot be reached.');
  await sets.change({ type: 'add', name: 'no parking' });
  server.outage = null;
  assert.equal(store.get().labels.length, 1);
  await receive();
  assert.deepEqual([store.get().labels.map(({ name }) => name), said], [['stop', 'no parking'], []]);
  const before = server.requests.length;
  await receive();
  assert.equal(server.requests.length, before, 'they are here');
});

test('a change by another person is loaded and announced', async () => {
  const { store, sets, server, said, receive } = createFixture();
  await sets.reload();
  server.version = 2;
  server.labels = [label({ id: 0, name: 'stop', hidden: true })];
  await receive();
  assert.deepEqual([store.get().labels[0].hidden, said], [true, ['Anna: Added ‘no parking’.']]);
  await receive(7, 'vienna');
  assert.equal(said.length, 1, 'another set is not on the screen');
});

test('another use of a set is no change of it', async () => {
  const { store, sets, server, said, receive } = createFixture();
  await sets.reload();
  store.dispatch((state) => ({ ...state, review: initialReview(/** @type {any} */ ({ id: 'v', label_set: 'vienna', frames: 9 })) }));
  await receive(1, 'vienna');
  assert.deepEqual([store.get().labels[0].name, said], ['boar', []]);
  server.version = 2;
  store.dispatch((state) => ({ ...state, review: null }));
  await receive();
  await receive();
  assert.equal(said.length, 1, 'a change is announced once');
});

test('a change that is refused brings in what stands in its way', async () => {
  const { store, sets, server } = createFixture();
  await sets.reload();
  server.labels = [...server.labels, label({ id: 9, name: 'no parking' })];
  server.refusal = new ApiError(409, 'taken', 'Anna has added it already.');
  await assert.rejects(sets.change({ type: 'add', name: 'no parking' }), /already/);
  assert.equal(store.get().labels.at(-1)?.id, 9);
  store.dispatch(setLabelSets, []);
  await assert.rejects(sets.change({ type: 'add', name: 'x' }), /not loaded yet/);
});

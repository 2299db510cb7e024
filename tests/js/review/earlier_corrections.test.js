// @ts-check
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { endOffer, offerEarlierCorrections } from '../../../static/js/review/earlier_corrections.js';
import { hideBanner, setRuns } from '../../../static/js/store/actions/page.js';
import { changeReview, openReview } from '../../../static/js/store/actions/review.js';
import { initialState } from '../../../static/js/store/initial.js';
import { createStore } from '../../../static/js/store/store.js';
import { isDismissed, dismiss } from '../../../static/js/core/preferences.js';
import { withStorage } from '../storage.js';

const signal = new AbortController().signal;
const OLD = /** @type {any} */ ({
  id: 'old',
  video_id: 'v',
  kind: 'engine',
  state: 'complete',
  name: 'Run 1',
  created: '2026-01-01T00:00:00Z',
});
const NEW = { ...OLD, id: 'new', name: 'Run 2' };

/** A later run on the screen, and what the server says of earlier ones. @param {any} answer @param {any} [run] */
function createFixture(answer, run = NEW) {
  const store = createStore(initialState());
  store.dispatch((state) =>
    changeReview(openReview(setRuns(state, 'v', [run, OLD]), /** @type {any} */ ({ id: 'v', frames: 10 })), { run }),
  );
  const requests = { count: 0 };
  const api = /** @type {any} */ ({
    earlier: async () => {
      requests.count += 1;
      return answer;
    },
  });
  return { store, api, requests, banner: () => store.get().banners.find(({ id }) => id === 'earlier') };
}

test('corrections of an earlier run are offered with an action', async () => {
  const page = createFixture({ run_id: 'old', tracks: 4, seq: 9 });
  await offerEarlierCorrections(page, NEW, signal);
  assert.match(page.banner()?.text ?? '', /^People have corrected 4 tracks in an earlier run, “Run 1 · /);
  assert.equal(page.banner()?.action?.operation, 'carry-over');
  assert.equal(page.store.get().review?.earlier?.run_id, 'old');
});

test('a hidden offer is not repeated until there are more corrections', async (t) => {
  withStorage(t);
  const page = createFixture({ run_id: 'old', tracks: 4, seq: 9 });
  await offerEarlierCorrections(page, NEW, signal);
  dismiss(page.banner()?.once ?? '');
  page.store.dispatch(hideBanner, 'earlier');
  await offerEarlierCorrections(page, NEW, signal);
  assert.equal(page.banner(), undefined);
  await offerEarlierCorrections(
    { ...page, api: /** @type {any} */ ({ earlier: async () => ({ run_id: 'old', tracks: 5, seq: 12 }) }) },
    NEW,
    signal,
  );
  assert.match(page.banner()?.text ?? '', /5 tracks/);
});

test('the offer ends after the corrections were adopted, also if nothing was written', async (t) => {
  withStorage(t);
  const page = createFixture({ run_id: 'old', tracks: 4, seq: 9 });
  await offerEarlierCorrections(page, NEW, signal);
  endOffer(page, 'new', 'another');
  assert.ok(page.banner(), 'those of another run came over');
  endOffer(page, 'new', 'old');
  assert.equal(page.banner(), undefined);
  assert.equal(page.store.get().review?.earlier, null);
  await offerEarlierCorrections(page, NEW, signal);
  assert.equal(page.banner(), undefined);
});

test('what-ifs and running runs are not checked; without a result there is no offer', async () => {
  for (const run of [
    { ...NEW, kind: 'whatif' },
    { ...NEW, state: 'running' },
  ]) {
    const page = createFixture({ run_id: 'old', tracks: 4, seq: 9 }, run);
    await offerEarlierCorrections(page, run, signal);
    assert.deepEqual([page.requests.count, page.banner()], [0, undefined]);
  }
  const page = createFixture(null);
  await offerEarlierCorrections(page, NEW, signal);
  assert.deepEqual([page.requests.count, page.banner()], [1, undefined]);
});

test('an answer that comes when another run is open says nothing', async () => {
  const page = createFixture({ run_id: 'old', tracks: 4, seq: 9 });
  page.store.dispatch(changeReview, { run: OLD });
  await offerEarlierCorrections(page, NEW, signal);
  assert.equal(page.banner(), undefined);
});

test('the list of hidden notices is bounded', (t) => {
  withStorage(t);
  for (let i = 0; i < 300; i += 1) dismiss(`n${i}`);
  assert.deepEqual([isDismissed('n299'), isDismissed('n200'), isDismissed('n199')], [true, true, false]);
});

// @ts-check
/**
 * Loads the data of the review screen into the store: video, run, tracks and lanes; overlays around the cursor; the
 * lane of the selected track. Follows a run in progress.
 *
 * @typedef {import('../page-types.js').App} App
 * @typedef {import('../state-types.js').State} State
 * @typedef {import('../types.js').Run} Run
 */
import { ApiError, mayRepeat, sentence } from '../api/errors.js';
import { NEXT_TRACK } from '../model/route.js';
import { createTimebase } from '../model/timebase.js';
import { tracksBehind } from '../model/track_lane.js';
import { hideBanner, showBanner, setRuns } from '../store/actions/page.js';
import { changeReview, closeReview, openReview, putLane, seek, select, selectedLanes } from '../store/actions/review.js';
import { createChunks } from './chunks.js';
import { offerEarlier } from './earlier.js';
import { createRequests } from './requests.js';

/** Minimum time between two reloads of a run in progress, ms. */
const FOLLOW = 1500;

/** Pause before a review is opened again after the server was unreachable, ms. */
const AGAIN = 2000;

/** @param {unknown} thrown */
const isOffline = (thrown) => thrown instanceof ApiError && thrown.code === 'offline';
/** Remove the banners of a review when it is closed. @param {State} state */
const withoutErrors = (state) => ['review', 'picture', 'earlier'].reduce(hideBanner, state);

/**
 * Put tracks and lanes into the store. The first ones select the track in the address; later ones leave the selection
 * alone.
 * @param {State} state
 * @param {Pick<import('../state-types.js').ReviewState, 'tracks'|'lanes'>} found
 * @returns {State}
 */
function putTracks(state, found) {
  const named =
    state.route.screen === 'review' && state.review?.tracks === null && state.review.selected === null ? state.route.track : null;
  const next = changeReview(state, found);
  return named === null || named === NEXT_TRACK ? next : select(next, named);
}

/**
 * @typedef {object} Loader
 * @property {() => void} sync                 follow a change of the state
 * @property {() => Promise<void>} refresh     load tracks and lanes of the run again
 * @property {(run: Run) => void} follow       a run has progressed
 * @property {(id: string|null, corrected?: boolean) => void} showSecond   another run's results as a layer, as the engine left them or as people corrected them
 * @property {(id: string|null) => void} showTruth    a ground truth of the video as a layer; null: any that exists
 * @property {() => void} destroy
 */

/**
 * @param {App} app
 * @param {{opened: (run: string) => Promise<void>|void, closed: () => void, first: () => void}} hooks   `opened`:
 *   resolves when people's corrections are loaded; `first`: opens the first undecided track
 * @returns {Loader}
 */
export function createLoader(app, hooks) {
  const { store, api } = app;
  /** @type {AbortController|null} */
  let current = null;
  let opened = '';
  /** @type {string|null} */
  let truth = null;
  /** The requested ground truth, perhaps before its video is open. @type {string|null} */
  let wantedTruth = null;
  /** The video that cannot be opened yet. @type {string|null} */
  let unready = null;
  let followed = -FOLLOW;
  /** Number of requests for tracks, and the number of the latest answer. */
  let asks = 0;
  let newest = 0;
  /** Whether the last reload failed and is repeated. */
  let late = false;
  const recovered = () => store.dispatch(hideBanner, 'review');
  const requests = createRequests(() => sync(), fail, recovered);
  const around = createChunks(app, requests, {
    truth: () => truth,
    truthGone(id, signal) {
      const review = store.get().review;
      if (review && truth === id) groundTruths(review.video.id, signal).catch((thrown) => fail(thrown, signal));
    },
    again: () => sync(),
  });
  /** @type {ReturnType<typeof setTimeout>|undefined} */
  let timer;

  /** @param {unknown} thrown @param {AbortSignal} signal */
  function fail(thrown, signal) {
    // another banner already says that the server cannot be reached
    if (signal.aborted || isOffline(thrown) || (thrown instanceof ApiError && thrown.code === 'aborted')) return;
    store.dispatch(showBanner, { id: 'review', tone: 'error', text: sentence(thrown) });
  }

  /** @param {Extract<State['route'], {screen: 'review'}>} route */
  async function open(route) {
    current?.abort();
    current = new AbortController();
    const signal = AbortSignal.any([current.signal, app.signal]);
    requests.clear();
    truth = null;
    hooks.closed();
    store.dispatch(withoutErrors);
    try {
      await app.load(() => api.video(route.video, { signal }), openReview);
      const video = store.get().review?.video;
      if (!video) return;
      unready = video.state === 'ready' ? null : video.id;
      if (unready !== null) return;
      const [table] = await Promise.all([
        api.frameTable(video.id, { signal }),
        app.load(
          () => api.runs(video.id, { signal }),
          (state, found) => setRuns(state, video.id, found),
        ),
      ]);
      const runs = store.get().runs[video.id] ?? [];
      // a missing run in the address is not replaced by another one, whose tracks would have the same names
      const run = runs.find(({ id }) => id === (route.run ?? video.latest_run)) ?? (route.run === null ? runs[0] : null) ?? null;
      store.dispatch((state) => {
        const ready = changeReview(state, {
          timebase: createTimebase(table),
          run,
          span: { first: 0, last: Math.max(1, table.frames) },
        });
        // the address may have changed meanwhile; from here on the user moves the cursor
        const { frame } = state.route.screen === 'review' ? state.route : route;
        return seek(ready, frame ?? run?.first ?? 0);
      });
      await Promise.all([run && load(run, signal), groundTruths(video.id, signal)]);
    } catch (thrown) {
      // the screen itself shows that a video does not exist
      if (store.get().review || !(thrown instanceof ApiError && thrown.status === 404)) fail(thrown, signal);
      if (mayRepeat(thrown)) setTimeout(() => !signal.aborted && void open(route), AGAIN);
    }
  }

  /** Tracks and lanes of a run; null: a later request was answered first. @param {string} run @param {AbortSignal} signal */
  async function tracksOf(run, signal) {
    const mine = ++asks;
    const [tracks, lanes] = await Promise.all([api.tracks(run, { signal }), api.lanes(run, { signal })]);
    if (mine < newest) return null;
    newest = mine;
    return { tracks, lanes };
  }

  /** @param {Run} run @param {AbortSignal} signal */
  async function load(run, signal) {
    const corrected = hooks.opened(run.id);
    if (run.state === 'queued' && run.frames_done === 0) return;
    const found = await tracksOf(run.id, signal);
    if (found) store.dispatch(putTracks, found);
    const { route } = store.get();
    const toFirst = route.screen === 'review' && route.track === NEXT_TRACK;
    if (toFirst) void Promise.resolve(corrected).then(() => signal.aborted || hooks.first());
    offerEarlier(app, run, signal).catch((thrown) => fail(thrown, signal));
  }

  /** @param {string} video @param {AbortSignal} signal */
  async function groundTruths(video, signal) {
    const found = await api.groundTruths(video, { signal });
    const shown = found.find(({ id }) => id === wantedTruth) ?? found[0];
    const next = shown?.id ?? null;
    store.dispatch(changeReview, {
      truthId: shown?.id ?? null,
      truthName: shown?.name ?? null,
      ...(truth !== null && truth !== next ? { truth: {} } : {}),
    });
    truth = next;
    sync();
  }

  /** @param {string} run @param {number} track @param {AbortSignal} signal */
  function lane(run, track, signal) {
    const name = `lane/${run}/${track}`;
    if (requests.isAskedFor(name)) return;
    void requests.fetched(
      name,
      signal,
      () => api.track(run, track, { signal }),
      (found) => {
        requests.passed(name);
        store.dispatch(putLane, found);
      },
    );
  }

  async function refresh() {
    const review = store.get().review;
    if (!review?.run || !current) return;
    const signal = AbortSignal.any([current.signal, app.signal]);
    requests.forget('truth/', true);
    requests.wake();
    try {
      const found = await tracksOf(review.run.id, signal);
      if (late) recovered();
      late = false;
      if (found === null) return;
      // tracks may have grown: reload the lanes of the selected track now, and others when they are selected
      store.dispatch((state) => changeReview(putTracks(state, found), (now) => ({ laneOf: selectedLanes(now) })));
      for (const track of Object.keys(store.get().review?.laneOf ?? {})) lane(review.run.id, Number(track), signal);
      sync();
    } catch (thrown) {
      fail(thrown, signal);
      late = mayRepeat(thrown);
      // nothing else would load the changes that an event has announced
      if (late) {
        clearTimeout(timer);
        timer = setTimeout(() => !signal.aborted && void refresh(), AGAIN);
      }
    }
  }

  function sync() {
    const { route, review } = store.get();
    const name = route.screen === 'review' ? `${route.video}/${route.run ?? '-'}` : '';
    if (route.screen === 'review' && name !== opened) {
      const sameVideo = opened.startsWith(`${route.video}/`) && review?.run && route.run === review.run.id;
      opened = name;
      if (!sameVideo) void open(route);
      return;
    }
    if (route.screen !== 'review') {
      if (opened) {
        opened = '';
        current?.abort();
        hooks.closed();
        store.dispatch((state) => withoutErrors(closeReview(state)));
      }
      return;
    }
    if (unready !== null && review?.video.id === unready && review.video.state === 'ready') {
      unready = null; // it was still being imported when it was opened
      void open(route);
      return;
    }
    if (!review?.timebase || !current) return;
    const signal = AbortSignal.any([current.signal, app.signal]);
    around(review, signal, current);
    if (review.run && review.selected) {
      for (const track of tracksBehind(review.selected, review.docs[review.selected]))
        if (!review.laneOf[track]) lane(review.run.id, track, signal);
    }
  }

  return {
    sync,
    refresh,
    follow(run) {
      const review = store.get().review;
      if (review === null || review.video.id !== run.video_id) return;
      if (review.timebase === null) return; // it is still being opened, and that loads the changes too
      if (review.run === null) {
        opened = ''; // show the first run of this video
        sync();
        return;
      }
      if (review.run.id !== run.id) return;
      clearTimeout(timer);
      const now = performance.now(); // if the clock were set back, the reloads would wait for it
      if (run.state !== 'running' || now - followed > FOLLOW) {
        followed = now;
        void refresh();
        if (current) offerEarlier(app, run, current.signal).catch(() => {}); // a failure is ignored: the next opening looks again
      } else {
        timer = setTimeout(() => void refresh(), FOLLOW);
      }
    },
    showSecond(id, corrected = false) {
      requests.forget('secondOverlays/');
      store.dispatch(changeReview, (review) => ({
        second: id,
        secondOverlays: {},
        secondTracks: null,
        secondDocs: {},
        layers: { ...review.layers, second: true },
      }));
      sync();
      if (!current || id === null) return;
      const signal = AbortSignal.any([current.signal, app.signal]);
      // the author matters only for undo, which is not used here
      Promise.all([api.tracks(id, { signal }), corrected ? api.annotation(id, 'someone', { signal }) : null])
        .then(([secondTracks, annotation]) => {
          const secondDocs = Object.fromEntries((annotation?.docs ?? []).map((doc) => [doc.key, doc]));
          store.dispatch((state) => (state.review?.second === id ? changeReview(state, { secondTracks, secondDocs }) : state));
        })
        .catch((thrown) => fail(thrown, signal));
    },
    showTruth(id) {
      wantedTruth = id;
      requests.forget('truth/');
      store.dispatch(changeReview, (review) => ({ truth: {}, layers: { ...review.layers, truth: id !== null || review.layers.truth } }));
      const { review } = store.get();
      if (!review || !current) return;
      const signal = AbortSignal.any([current.signal, app.signal]);
      groundTruths(review.video.id, signal).catch((thrown) => fail(thrown, signal));
    },
    destroy() {
      clearTimeout(timer);
      current?.abort();
    },
  };
}

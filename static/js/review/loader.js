// @ts-check
/**
 * Loads the data of the review screen into the store: video, run, tracks and lanes; overlays around the cursor; the
 * lane of the selected track. Follows a run in progress.
 *
 * @typedef {import('../page-types.js').App} App
 * @typedef {import('../state-types.js').State} State
 * @typedef {import('../types.js').Run} Run
 */
import { ApiError, isRetryable, errorMessage } from '../api/errors.js';
import { NEXT_TRACK } from '../model/route.js';
import { createTimebase } from '../model/timebase.js';
import { engineTracksOf } from '../model/track_lane.js';
import { hideBanner, showBanner, setRuns } from '../store/actions/page.js';
import { changeReview, closeReview, openReview, putLane, seek, select, selectedLanes } from '../store/actions/review.js';
import { createChunks } from './chunks.js';
import { offerEarlierCorrections } from './earlier_corrections.js';
import { createRequests } from './requests.js';

/** Minimum time between two reloads of a run in progress, ms. */
const MIN_RELOAD_INTERVAL_MS = 1500;

/** Delay before a failed opening or reload is repeated, ms. */
const RETRY_DELAY_MS = 2000;

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
  const requestedTrack =
    state.route.screen === 'review' && state.review?.tracks === null && state.review.selected === null ? state.route.track : null;
  const next = changeReview(state, found);
  return requestedTrack === null || requestedTrack === NEXT_TRACK ? next : select(next, requestedTrack);
}

/**
 * @typedef {object} Loader
 * @property {() => void} sync                 follow a change of the state
 * @property {() => Promise<void>} refresh     load tracks and lanes of the run again
 * @property {(run: Run) => void} onProgress       a run has progressed
 * @property {(id: string|null, corrected?: boolean) => void} showSecond   another run's results as a layer, as the engine left them or as people corrected them
 * @property {(id: string|null) => void} showTruth    a ground truth of the video as a layer; null: any that exists
 */

/**
 * @param {App} app
 * @param {{onOpened: (run: string) => Promise<void>|void, onClosed: () => void, openFirst: () => void}} hooks   `onOpened`:
 *   resolves when people's corrections are loaded; `openFirst`: opens the first undecided track
 * @returns {Loader}
 */
export function createLoader(app, hooks) {
  const { store, api } = app;
  /** @type {AbortController|null} */
  let opening = null;
  /** Aborts when another review is opened, or the page ends. */
  let openSignal = app.signal;
  let openedRoute = '';
  /** @type {string|null} */
  let truthId = null;
  /** The requested ground truth, perhaps before its video is open. @type {string|null} */
  let requestedTruthId = null;
  /** Id of a video whose import has not ended: it cannot be opened yet. @type {string|null} */
  let importingVideo = null;
  let lastReload = -MIN_RELOAD_INTERVAL_MS;
  /** Number of requests for tracks, and the number of the latest answer. */
  let requestCount = 0;
  let newestAnswer = 0;
  /** Whether the last reload failed and is repeated. */
  let isRetrying = false;
  const hideError = () => store.dispatch(hideBanner, 'review');
  const requests = createRequests(() => sync(), fail, hideError);
  const loadAround = createChunks(app, requests, {
    truthId: () => truthId,
    onTruthMissing(id, signal) {
      const review = store.get().review;
      if (review && truthId === id) reloadGroundTruths(review.video.id, signal);
    },
    onLoaded: () => sync(),
  });
  /** @type {ReturnType<typeof setTimeout>|undefined} */
  let timer;

  /** @param {unknown} thrown @param {AbortSignal} signal */
  function fail(thrown, signal) {
    // another banner already says that the server cannot be reached
    if (signal.aborted || (thrown instanceof ApiError && ['offline', 'aborted'].includes(thrown.code))) return;
    store.dispatch(showBanner, { id: 'review', tone: 'error', text: errorMessage(thrown) });
  }

  /** @param {Extract<State['route'], {screen: 'review'}>} route */
  async function open(route) {
    opening?.abort();
    opening = new AbortController();
    const signal = (openSignal = AbortSignal.any([opening.signal, app.signal]));
    requests.clear();
    truthId = null;
    hooks.onClosed();
    store.dispatch(withoutErrors);
    try {
      await app.load(() => api.video(route.video, { signal }), openReview);
      const video = store.get().review?.video;
      if (!video) return;
      importingVideo = video.state === 'ready' ? null : video.id;
      if (importingVideo !== null) return;
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
      await Promise.all([run && loadRun(run, signal), loadGroundTruths(video.id, signal)]);
    } catch (thrown) {
      // the screen itself shows that a video does not exist
      if (store.get().review || !(thrown instanceof ApiError && thrown.status === 404)) fail(thrown, signal);
      if (isRetryable(thrown)) setTimeout(() => !signal.aborted && void open(route), RETRY_DELAY_MS);
    }
  }

  /** Tracks and lanes of a run; null: a later request was answered first. @param {string} run @param {AbortSignal} signal */
  async function loadTracks(run, signal) {
    const number = ++requestCount;
    const [tracks, lanes] = await Promise.all([api.tracks(run, { signal }), api.lanes(run, { signal })]);
    if (number < newestAnswer) return null;
    newestAnswer = number;
    return { tracks, lanes };
  }

  /** @param {Run} run @param {AbortSignal} signal */
  async function loadRun(run, signal) {
    const corrected = hooks.onOpened(run.id);
    if (run.state === 'queued' && run.frames_done === 0) return;
    const found = await loadTracks(run.id, signal);
    if (found) store.dispatch(putTracks, found);
    const { route } = store.get();
    const toFirst = route.screen === 'review' && route.track === NEXT_TRACK;
    if (toFirst) void Promise.resolve(corrected).then(() => signal.aborted || hooks.openFirst());
    offerEarlierCorrections(app, run, signal).catch((thrown) => fail(thrown, signal));
  }

  /** @param {string} video @param {AbortSignal} signal */
  async function loadGroundTruths(video, signal) {
    const found = await api.groundTruths(video, { signal });
    const shown = found.find(({ id }) => id === requestedTruthId) ?? found[0];
    const next = shown?.id ?? null;
    const hasChanged = truthId !== null && truthId !== next;
    store.dispatch(changeReview, { truthId: next, truthName: shown?.name ?? null, ...(hasChanged ? { truth: {} } : {}) });
    truthId = next;
    sync();
  }

  /** @param {string} video @param {AbortSignal} signal */
  const reloadGroundTruths = (video, signal) => void loadGroundTruths(video, signal).catch((thrown) => fail(thrown, signal));

  /** @param {string} run @param {number} track @param {AbortSignal} signal */
  function loadLane(run, track, signal) {
    const name = `lane/${run}/${track}`;
    if (requests.isRequested(name)) return;
    void requests.load(
      name,
      signal,
      () => api.track(run, track, { signal }),
      (found) => {
        requests.forget(name);
        store.dispatch(putLane, found);
      },
    );
  }

  async function refresh() {
    const review = store.get().review;
    if (!review?.run || !opening) return;
    const signal = openSignal;
    requests.forgetPrefix('truth/', true);
    requests.retryNow();
    try {
      const found = await loadTracks(review.run.id, signal);
      if (isRetrying) hideError();
      isRetrying = false;
      if (found === null) return;
      // tracks may have grown: reload the lanes of the selected track now, and others when they are selected
      store.dispatch((state) => changeReview(putTracks(state, found), (now) => ({ laneOf: selectedLanes(now) })));
      for (const track of Object.keys(store.get().review?.laneOf ?? {})) loadLane(review.run.id, Number(track), signal);
      sync();
    } catch (thrown) {
      fail(thrown, signal);
      isRetrying = isRetryable(thrown);
      // nothing else would load the changes that an event has announced
      if (isRetrying) {
        clearTimeout(timer);
        timer = setTimeout(() => !signal.aborted && void refresh(), RETRY_DELAY_MS);
      }
    }
  }

  function sync() {
    const { route, review } = store.get();
    const routeName = route.screen === 'review' ? `${route.video}/${route.run ?? '-'}` : '';
    if (route.screen === 'review' && routeName !== openedRoute) {
      const sameVideo = openedRoute.startsWith(`${route.video}/`) && review?.run && route.run === review.run.id;
      openedRoute = routeName;
      if (!sameVideo) void open(route);
      return;
    }
    if (route.screen !== 'review') {
      if (openedRoute) {
        openedRoute = '';
        opening?.abort();
        hooks.onClosed();
        store.dispatch((state) => withoutErrors(closeReview(state)));
      }
      return;
    }
    if (importingVideo !== null && review?.video.id === importingVideo && review.video.state === 'ready') {
      importingVideo = null; // it was still being imported when it was opened
      void open(route);
      return;
    }
    if (!review?.timebase || !opening) return;
    loadAround(review, openSignal, opening);
    if (review.run && review.selected) {
      for (const track of engineTracksOf(review.selected, review.docs[review.selected]))
        if (!review.laneOf[track]) loadLane(review.run.id, track, openSignal);
    }
  }

  return {
    sync,
    refresh,
    onProgress(run) {
      const review = store.get().review;
      if (review === null || review.video.id !== run.video_id) return;
      if (review.timebase === null) return; // it is still being opened, and that loads the changes too
      if (review.run === null) {
        openedRoute = ''; // show the first run of this video
        sync();
        return;
      }
      if (review.run.id !== run.id) return;
      clearTimeout(timer);
      const now = performance.now(); // if the clock were set back, the reloads would wait for it
      if (run.state !== 'running' || now - lastReload > MIN_RELOAD_INTERVAL_MS) {
        lastReload = now;
        void refresh();
        if (opening) offerEarlierCorrections(app, run, openSignal).catch(() => {}); // a failure is ignored: the next opening asks again
      } else {
        timer = setTimeout(() => void refresh(), MIN_RELOAD_INTERVAL_MS);
      }
    },
    showSecond(id, corrected = false) {
      requests.forgetPrefix('secondOverlays/');
      store.dispatch(changeReview, (review) => ({
        second: id,
        secondOverlays: {},
        secondTracks: null,
        secondDocs: {},
        layers: { ...review.layers, second: true },
      }));
      sync();
      if (!opening || id === null) return;
      const signal = openSignal;
      // the author matters only for undo, which is not used here
      Promise.all([api.tracks(id, { signal }), corrected ? api.annotation(id, 'someone', { signal }) : null])
        .then(([secondTracks, annotation]) => {
          const secondDocs = Object.fromEntries((annotation?.docs ?? []).map((doc) => [doc.key, doc]));
          store.dispatch((state) => (state.review?.second === id ? changeReview(state, { secondTracks, secondDocs }) : state));
        })
        .catch((thrown) => fail(thrown, signal));
    },
    showTruth(id) {
      requestedTruthId = id;
      requests.forgetPrefix('truth/');
      store.dispatch(changeReview, (review) => ({ truth: {}, layers: { ...review.layers, truth: id !== null || review.layers.truth } }));
      const { review } = store.get();
      if (review && opening) reloadGroundTruths(review.video.id, openSignal);
    },
  };
}

// @ts-check
/** Keeps the store up to date with the server: event stream, first load, reload after a gap. */

import { ApiError, isRetryable, errorMessage } from '../api/errors.js';
import { openStream } from '../api/events.js';
import { setAssignments } from '../store/actions/team.js';
import {
  hideBanner,
  setOutputs,
  setConnection,
  setModels,
  setParameters,
  setSession,
  setVideos,
  showBanner,
} from '../store/actions/page.js';
import { loadRuns } from './load_runs.js';

/** @typedef {import('../page-types.js').App} App */
/** @typedef {import('../types.js').ServerEvent} ServerEvent */

/** The longest interruption without a banner, ms, for example while a laptop sleeps. */
const OFFLINE_BANNER_DELAY_MS = 2500;
/** Pause before a failed load is repeated because the server was unreachable or busy, ms. */
const RETRY_DELAY_MS = 2000;
/** The longest wait of the first load for the stream, ms: a hidden page has none, and a proxy may delay it. */
const FIRST_LOAD_DELAY_MS = 1000;
/** Version of the page's files, in the address of each; null: the address has none, as in tests. */
const PAGE_FILES = /\/static\/v-([0-9a-f]{16})\//.exec(import.meta.url)?.[1] ?? null;

/**
 * @param {App} app
 * @param {{onEvent?: (event: ServerEvent) => void, onReset?: () => void, onReconnect?: () => void, files?: string|null, open?: typeof openStream, retryDelayMs?: number, signIn?: () => void}} [hooks]
 * onEvent: called after the store has taken `video`, `run` and `removed`; also for `edit`. onReset: events were missed,
 * so the data of a review may be old. onReconnect: the server was unreachable. files: version of the page's files
 * @returns {Pick<import('../api/events.js').Stream, 'retry'|'pause'|'resume'> & {reload: () => Promise<void>}}
 */
export function startLiveUpdates(app, hooks = {}) {
  const { store, api } = app;
  const files = hooks.files ?? PAGE_FILES;
  const openEvents = hooks.open ?? openStream;
  const signIn = hooks.signIn ?? (() => location.replace(`/sign-in${location.hash}`));
  let wasOnline = false;
  /** Version of the server when the page was loaded. @type {string|null} */
  let version = null;
  /** Whether the server refuses because nobody is signed in; it is reachable then. */
  let isDenied = false;
  /** @type {ReturnType<typeof setTimeout>|undefined} */ let offlineTimer;
  /** @type {ReturnType<typeof setTimeout>|undefined} */ let retryTimer;

  const stream = openEvents({
    signal: app.signal,
    onEvent: (event) => {
      app.receive(event);
      hooks.onEvent?.(event);
    },
    onStorage: (text) => {
      store.dispatch((state) => (text === null ? hideBanner(state, 'storage') : showBanner(state, { id: 'storage', tone: 'error', text })));
    },
    onConnection: (connection) => {
      clearTimeout(offlineTimer);
      if (connection === 'online') {
        store.dispatch((state) => hideBanner(hideBanner(hideBanner(setConnection(state, 'online'), 'offline'), 'denied'), 'storage'));
        // From now on, changes arrive as events. After a refusal, another person may be signed in now.
        if (!wasOnline || isDenied) void reload();
        else void api.session().then(compareVersion, () => {}); // it may have been upgraded while it was unreachable
        if (wasOnline) hooks.onReconnect?.();
        [wasOnline, isDenied] = [true, false];
      } else if (!isDenied) {
        offlineTimer = setTimeout(
          () =>
            store.dispatch((state) =>
              showBanner(setConnection(state, 'offline'), {
                id: 'offline',
                tone: 'warning',
                text: 'The server cannot be reached. Your changes are kept in this page and saved when it is back.',
              }),
            ),
          OFFLINE_BANNER_DELAY_MS,
        );
      }
    },
    onReset: () => {
      void reload();
      hooks.onReset?.();
    },
    onDenied: () => {
      isDenied = true;
      clearTimeout(offlineTimer);
      void showDenied();
    },
  });
  // a change between a load and the start of the stream would be missed, so the first load waits for the stream
  retryTimer = setTimeout(() => void reload(), FIRST_LOAD_DELAY_MS);
  app.signal.addEventListener(
    'abort',
    () => {
      clearTimeout(offlineTimer);
      clearTimeout(retryTimer);
    },
    { once: true },
  );

  /** Offer to reload a page that came from another version or build of the server. @param {import('../types.js').Session} session */
  function compareVersion(session) {
    version ??= session.version;
    const server = session.version === version ? `another build of tsr ${version}` : `tsr ${session.version}`;
    const origin = session.version === version ? 'an older one' : version;
    store.dispatch((state) =>
      session.version === version && (files === null || session.page === files)
        ? hideBanner(state, 'version')
        : showBanner(state, {
            id: 'version',
            tone: 'warning',
            action: { label: 'Reload', operation: 'reload' },
            text: `The server runs ${server} now, and this page is from ${origin}. Reload it; unsaved changes are kept.`,
          }),
    );
  }

  /** Show the server's reason; in a library with people, offer to sign in again. */
  async function showDenied() {
    const denial = await api.session().then(
      () => null,
      (thrown) => (thrown instanceof ApiError && (thrown.status === 401 || thrown.status === 403) ? thrown : null),
    );
    if (denial === null || app.signal.aborted) return;
    const isSignedOut = denial.code === 'signed_out';
    if (isSignedOut && store.get().session === null) return void signIn();
    store.dispatch(showBanner, {
      id: 'denied',
      tone: 'error',
      ...(isSignedOut && { action: { label: 'Sign in', operation: 'sign-in' } }),
      text: isSignedOut
        ? 'You are signed out. Unsaved changes are kept in this browser until you sign in again.'
        : `${denial.message} Your work in this page is kept until you close it.`,
    });
  }

  async function reload() {
    clearTimeout(retryTimer);
    try {
      await app.load(
        () => Promise.all([api.session(), app.labels.reload(), api.parameters(), api.videos()]),
        (state, [session, , parameters, videos]) => setVideos(setParameters(setSession(state, session), parameters), videos),
      );
      store.dispatch(hideBanner, 'load');
      const { session } = store.get();
      if (session) compareVersion(session);
      if (session?.person) await app.load(() => api.assignments(), setAssignments);
      // model versions only tell runs apart; everything else works without them
      await app.load(
        () => Promise.all([api.outputs(), api.models().catch(() => store.get().models)]),
        (state, [outputs, models]) => (models ? setModels(setOutputs(state, outputs), models) : setOutputs(state, outputs)),
      );
      for (const video of Object.keys(store.get().runs)) await loadRuns(app, video);
    } catch (thrown) {
      if (app.signal.aborted) return;
      if (thrown instanceof ApiError && thrown.code === 'signed_out') return void showDenied();
      store.dispatch(showBanner, { id: 'load', tone: 'error', text: errorMessage(thrown) });
      // no event would remove the banner
      clearTimeout(retryTimer);
      if (isRetryable(thrown)) retryTimer = setTimeout(() => void reload(), hooks.retryDelayMs ?? RETRY_DELAY_MS);
    }
  }

  return { retry: stream.retry, pause: stream.pause, resume: stream.resume, reload };
}

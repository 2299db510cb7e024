// @ts-check
/** Puts the page together. */

import { createApi } from './api/client.js';
import { errorMessage } from './api/errors.js';
import { listenToKeys } from './behaviours/keyboard.js';
import * as preferences from './core/preferences.js';
import { endToasts, toast } from './core/toast.js';
import { createBackgroundSender } from './editing/background_sender.js';
import { createEditor } from './editing/editor.js';
import { createLabelSets } from './editing/label_sets.js';
import { createNoteDrafts } from './editing/note_drafts.js';
import { createMemoryOutbox, createOutbox } from './editing/outbox.js';
import { createUserOutbox } from './editing/user_outbox.js';
import { createFrames } from './frames/frames.js';
import { NEXT_TRACK, parseRoute, currentAddress, isSameView } from './model/route.js';
import { openFirst } from './operations/navigate.js';
import { allOperations } from './operations/registry.js';
import { createFollowPrefetch } from './review/follow_prefetch.js';
import { createFollowControl } from './review/follow_control.js';
import { createLoader } from './review/loader.js';
import { closeDialog, setRoute, setTheme, setVideos, showBanner } from './store/actions/page.js';
import { seek, select } from './store/actions/review.js';
import { createCatchUp } from './store/catch_up.js';
import { initialState } from './store/initial.js';
import { createStore } from './store/store.js';
import { unsavedOf } from './store/unsaved.js';
import { startLiveUpdates } from './views/live_updates.js';
import { reloadFailedImages } from './views/images.js';
import { createShell } from './views/shell.js';

/** @typedef {import('./page-types.js').App} App */

// the page would start in part, and report what is missing beside the note of `browser-check.js`
if (document.documentElement.dataset.tooOld) throw new Error('The browser is too old for the page.');

const pageEnd = new AbortController();
/** Options of listeners. */
const untilEnd = { signal: pageEnd.signal };
const store = createStore({
  ...initialState(),
  theme: preferences.rememberedTheme(),
  layers: preferences.rememberedLayers(),
  fewLabels: preferences.rememberedFewLabels(),
  lanesView: preferences.rememberedLanesView(),
});
preferences.rememberChoices(store);
const api = createApi({ signal: pageEnd.signal });
const frames = createFrames(store, api);
/** Resolves when the server has answered who is signed in. @type {Promise<void>} */
const personKnown = new Promise((resolve) => {
  const end = store.subscribe(({ session }) => {
    if (session === null) return;
    end();
    resolve();
  });
});
const outbox = createUserOutbox(
  globalThis.indexedDB ? createOutbox() : createMemoryOutbox(),
  personKnown,
  () => store.get().session?.person?.name ?? null,
);
const backgroundSender = createBackgroundSender({ store, api, outbox, signal: pageEnd.signal, toast });
const author = () => preferences.authorName(store.get().session) || store.get().session?.author || 'someone';
const editor = createEditor({
  store,
  api,
  outbox,
  backgroundSender,
  signal: pageEnd.signal,
  toast,
  onEdit: endToasts,
  author,
});
const following = createFollowControl({ store, api, edit: editor.edit, author, signal: pageEnd.signal, toast });
const followPrefetch = createFollowPrefetch({ store, api, signal: pageEnd.signal });
/** @type {App} */
const app = {
  store,
  api,
  labels: createLabelSets({
    store,
    api,
    author,
    notify: (text) => toast(text, { topic: 'labels', stays: true }),
    onChanged: () => void app.loader.refresh(),
  }),
  ...createCatchUp(store),
  operations: allOperations(),
  frames,
  signal: pageEnd.signal,
  edit: editor.edit,
  editor,
  notes: createNoteDrafts(() => sessionStorage),
  loader: /** @type {any} */ (null),
  following,
};
app.loader = createLoader(app, {
  onOpened: (run) => {
    following.open(run);
    return editor.open(run).catch((thrown) => store.dispatch(showBanner, { id: 'review', tone: 'error', text: errorMessage(thrown) }));
  },
  onClosed: () => {
    following.close();
    editor.close();
  },
  openFirst: () => openFirst(app),
});

/** The address that was last read or written here. */
let lastHash = '';

function readRoute() {
  lastHash = location.hash;
  const route = parseRoute(lastHash);
  const before = store.get().route.screen;
  // a dialog belongs to the screen, the video and the run on which it was opened
  store.dispatch((state) => setRoute(isSameView(state.route, route, state.review?.run?.id ?? null) ? state : closeDialog(state), route));
  // its progress may have changed since the last visit, through a review here or by somebody else
  if (route.screen === 'library' && before !== 'library') void app.load(() => api.videos(), setVideos).catch(() => {});
  const { review } = store.get();
  if (route.screen === 'review' && review?.video.id === route.video && (route.run === null || route.run === review.run?.id)) {
    if (route.frame !== null) store.dispatch(seek, route.frame);
    if (route.track === NEXT_TRACK) openFirst(app);
    else if (route.track !== null) store.dispatch(select, route.track);
  }
}

/** @type {ReturnType<typeof setTimeout>|undefined} */
let writeTimer;

/** Write the route to the address, so that it can be copied and survives a reload. */
function writeRoute() {
  clearTimeout(writeTimer);
  writeTimer = undefined;
  // the user has just changed it, and the event for that is on its way
  if (location.hash !== lastHash) return readRoute();
  const address = currentAddress(store.get());
  if (address === null) return;
  if (lastHash !== address) history.replaceState(null, '', address);
  lastHash = location.hash;
}

const shell = createShell(app);
document.getElementById('app')?.replaceChildren(shell.element);
let scheduled = false;
store.subscribe(() => {
  app.loader.sync();
  frames.sync();
  followPrefetch.sync();
  app.labels.sync();
  if (!scheduled) {
    scheduled = true;
    requestAnimationFrame(() => {
      scheduled = false;
      shell.update(store.get());
    });
  }
  writeTimer ??= setTimeout(writeRoute, 300);
});
addEventListener('hashchange', readRoute, untilEnd);
addEventListener('pagehide', writeRoute, untilEnd);
// the outbox keeps them, but only in this browser
addEventListener('beforeunload', (event) => unsavedOf(store.get()).unsaved && event.preventDefault(), untilEnd);
/** A defect of the page. @param {unknown} thrown */
const reportDefect = (thrown) => toast(errorMessage(thrown), { tone: 'bad', topic: 'defect' });
addEventListener('error', ({ error }) => error instanceof Error && reportDefect(error), untilEnd);
addEventListener('unhandledrejection', ({ reason }) => reason?.name !== 'AbortError' && reportDefect(reason), untilEnd);
listenToKeys(app, toast, () => shell.update(store.get()));
const live = startLiveUpdates(app, {
  onEvent: (event) => {
    const { review } = store.get();
    if (event.kind === 'edit' && review?.run?.id === event.subject) {
      if (event.data.docs) editor.receive(event.data.docs, event.data.op_id, event.data.author);
      else void editor.refresh(); // an import of very many tracks
    }
    if (event.kind === 'run') app.loader.onProgress(event.data);
    if (event.kind === 'people') void live.reload(); // the user's own role may have changed
    if (event.kind === 'labels') void app.labels.receive(event).catch(() => {});
    if (event.kind === 'space') dispatchEvent(new CustomEvent('tsr:scene3d', { detail: event.data }));
  },
  onReconnect: () => reloadFailedImages(),
  onReset: () => {
    void app.loader.refresh();
    void editor.refresh();
  },
});
// the browser knows that a network has gone or come: the present connection may be dead
for (const change of ['online', 'offline']) addEventListener(change, live.retry, untilEnd);
/**
 * Only visible pages listen. By HTTP/1.1 a browser has six connections to a server, for all of its pages together, and
 * six listening pages would leave none.
 */
const listenIfVisible = () => (document.hidden ? live.pause() : live.resume());
document.addEventListener('visibilitychange', listenIfVisible, untilEnd);
listenIfVisible();
store.dispatch(setTheme, preferences.rememberedTheme());
readRoute();
shell.update(store.get());
// edits that an earlier visit has left unsaved
void backgroundSender.flush();
/** For tests, and for people at the browser's console. */
Object.assign(globalThis, { tsr: { store, frames } });

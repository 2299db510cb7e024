// @ts-check
/** Puts the page together. */

import { createApi } from './api/client.js';
import { sentence } from './api/errors.js';
import { listenToKeys } from './behaviours/keyboard.js';
import {
  rememberChoices,
  rememberedFewLabels,
  rememberedLanesView,
  rememberedLayers,
  rememberedTheme,
  signature,
} from './core/preferences.js';
import { endToasts, toast } from './core/toast.js';
import { createBackground } from './editing/background.js';
import { createEditor } from './editing/editor.js';
import { createLabelSets } from './editing/label_sets.js';
import { createNoteDrafts } from './editing/note_drafts.js';
import { createMemoryOutbox, createOutbox } from './editing/outbox.js';
import { createOwnOutbox } from './editing/own_outbox.js';
import { createFrames } from './frames/frames.js';
import { NEXT_TRACK, parseRoute, placeOf, samePlace } from './model/route.js';
import { openFirst } from './operations/navigate.js';
import { allOperations } from './operations/registry.js';
import { createExpecting } from './review/expecting.js';
import { createFollowing } from './review/following.js';
import { createLoader } from './review/loader.js';
import { closeDialog, setRoute, setTheme, setVideos, showBanner } from './store/actions/page.js';
import { seek, select } from './store/actions/review.js';
import { createCatchUp } from './store/catch_up.js';
import { initialState } from './store/initial.js';
import { createStore } from './store/store.js';
import { unsavedOf } from './store/unsaved.js';
import { startLive } from './views/live.js';
import { reloadMissing } from './views/pictures.js';
import { createShell } from './views/shell.js';

/** @typedef {import('./page-types.js').App} App */

const ended = new AbortController();
const store = createStore({
  ...initialState(),
  theme: rememberedTheme(),
  layers: rememberedLayers(),
  fewLabels: rememberedFewLabels(),
  lanesView: rememberedLanesView(),
});
rememberChoices(store);
const api = createApi({ signal: ended.signal });
const frames = createFrames(store, api);
/** Resolves when the server has answered who is signed in. @type {Promise<void>} */
const personKnown = new Promise((resolve) => {
  const end = store.subscribe(({ session }) => {
    if (session === null) return;
    end();
    resolve();
  });
});
const outbox = createOwnOutbox(
  globalThis.indexedDB ? createOutbox() : createMemoryOutbox(),
  personKnown,
  () => store.get().session?.person?.name ?? null,
);
const background = createBackground({ store, api, outbox, signal: ended.signal, toast });
const author = () => signature(store.get().session) || store.get().session?.author || 'someone';
const editor = createEditor({
  store,
  api,
  outbox,
  background,
  signal: ended.signal,
  toast,
  edited: endToasts,
  author,
});
const following = createFollowing({ store, api, edit: editor.edit, author, signal: ended.signal, toast });
const expecting = createExpecting({ store, api, signal: ended.signal });
/** @type {App} */
const app = {
  store,
  api,
  labels: createLabelSets({
    store,
    api,
    author,
    say: (text) => toast(text, { topic: 'labels', stays: true }),
    turned: () => void app.loader.refresh(),
  }),
  ...createCatchUp(store),
  operations: allOperations(),
  frames,
  signal: ended.signal,
  edit: editor.edit,
  editor,
  notes: createNoteDrafts(() => sessionStorage),
  loader: /** @type {any} */ (null),
  following,
};
app.loader = createLoader(app, {
  opened: (run) => {
    following.open(run);
    return editor.open(run).catch((thrown) => store.dispatch(showBanner, { id: 'review', tone: 'error', text: sentence(thrown) }));
  },
  closed: () => {
    following.close();
    editor.close();
  },
  first: () => openFirst(app),
});

/** The address that was last read or written here. */
let known = '';

function readRoute() {
  known = location.hash;
  const route = parseRoute(known);
  const before = store.get().route.screen;
  // a dialog belongs to the screen, the video and the run on which it was opened
  store.dispatch((state) => setRoute(samePlace(state.route, route, state.review?.run?.id ?? null) ? state : closeDialog(state), route));
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
let written;

/** Write the route to the address, so that it can be copied and survives a reload. */
function writeRoute() {
  clearTimeout(written);
  written = undefined;
  // the user has just changed it, and the event for that is on its way
  if (location.hash !== known) return readRoute();
  const wanted = placeOf(store.get());
  if (wanted === null) return;
  if (known !== wanted) history.replaceState(null, '', wanted);
  known = location.hash;
}

const shell = createShell(app);
document.getElementById('app')?.replaceChildren(shell.element);
let scheduled = false;
store.subscribe(() => {
  app.loader.sync();
  frames.sync();
  expecting.sync();
  app.labels.sync();
  if (!scheduled) {
    scheduled = true;
    requestAnimationFrame(() => {
      scheduled = false;
      shell.update(store.get());
    });
  }
  written ??= setTimeout(writeRoute, 300);
});
addEventListener('hashchange', readRoute, { signal: ended.signal });
addEventListener('pagehide', writeRoute, { signal: ended.signal });
addEventListener(
  'beforeunload',
  (event) => {
    // the outbox keeps them, but only in this browser
    if (unsavedOf(store.get()).unsaved) event.preventDefault();
  },
  { signal: ended.signal },
);
listenToKeys(app, toast, () => shell.update(store.get()));
const live = startLive(app, {
  onEvent: (event) => {
    const { review } = store.get();
    if (event.kind === 'edit' && review?.run?.id === event.subject) {
      if (event.data.docs) editor.receive(event.data.docs, event.data.op_id, event.data.author);
      else void editor.refresh(); // an import of very many tracks
    }
    if (event.kind === 'run') app.loader.follow(event.data);
    if (event.kind === 'people') void live.reload(); // the user's own role may have changed
    if (event.kind === 'labels') void app.labels.receive(event).catch(() => {});
    if (event.kind === 'space') dispatchEvent(new CustomEvent('tsr:scene3d', { detail: event.data }));
  },
  onBack: () => reloadMissing(),
  onReset: () => {
    void app.loader.refresh();
    void editor.refresh();
  },
});
// the browser knows that a network has gone or come: the present connection may be dead
for (const change of ['online', 'offline']) addEventListener(change, live.retry, { signal: ended.signal });
void live.reload();
store.dispatch(setTheme, rememberedTheme());
readRoute();
shell.update(store.get());
// edits that an earlier visit has left unsaved
void background.go();
/** For tests, and for people at the browser's console. */
Object.assign(globalThis, { tsr: { store, frames } });

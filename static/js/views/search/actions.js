// @ts-check
/** Actions on the selected tracks: one operation per run, and one undo for all. */

import { sentence } from '../../api/errors.js';
import { openDialog, setRuns } from '../../store/actions/page.js';
import { h, setText } from '../dom.js';
import { count, plural } from '../../model/format.js';
import { icon } from '../icons.js';
import { authorName } from '../../core/preferences.js';
import { toast } from '../../core/toast.js';

/** @typedef {import('../../types.js').FoundTrack} FoundTrack */
/** @typedef {import('../../api/search.js').TrackAction} TrackAction */
/** @typedef {import('../../api/search.js').TracksDone} TracksDone */

/**
 * @param {import('../../page-types.js').App} app
 * @param {object} setup
 * @param {() => FoundTrack[]} setup.selected
 * @param {(tracks: FoundTrack[]) => void} setup.changed   the tracks after the action
 * @param {() => void} setup.anew                          search again
 * @param {() => void} setup.open
 * @param {() => void} setup.all
 * @param {() => void} setup.none
 * @param {AbortSignal} setup.signal
 */
export function createSearchActions(app, { selected, changed, anew, open, all, none, signal }) {
  const { store, api } = app;
  /** Actions that can be undone, newest last. @type {{operations: TracksDone['operations'], what: string}[]} */
  const done = [];
  let busy = false;
  const author = () => authorName(store.get().session) || store.get().session?.author || null;

  /** @param {TrackAction} action @param {string} what   begins a sentence */
  async function act(action, what) {
    const tracks = selected();
    if (tracks.length === 0 || busy) return;
    await carryOut(async () => {
      const wanted = tracks.map(({ run, key, revision }) => ({ run, key, revision }));
      const answer = await api.actOnTracks({ action_id: crypto.randomUUID(), author: author(), action, tracks: wanted }, { signal });
      if (answer.operations.length > 0) done.push({ operations: answer.operations, what });
      const text =
        answer.changed > 0
          ? `${what}: ${plural(answer.changed, 'track')} in ${plural(answer.operations.length, 'run')}.`
          : answer.stayed > 0
            ? 'Nothing was changed.'
            : 'Nothing changes: the tracks already have this value.';
      tell(answer, text, answer.operations.length > 0);
      return answer;
    });
  }

  async function undo() {
    const last = done.at(-1);
    if (!last) {
      toast('There is nothing left to undo here.', { topic: 'search' });
      return;
    }
    if (busy) return;
    await carryOut(async () => {
      const answer = await api.undoTracks({ author: author(), operations: last.operations }, { signal });
      done.splice(done.indexOf(last), 1);
      tell(answer, `Undone: ${last.what.toLowerCase()}, ${plural(answer.changed, 'track')}.`, false);
      return answer;
    });
  }

  /** @param {() => Promise<TracksDone>} ask */
  async function carryOut(ask) {
    busy = true;
    show(selected().length);
    try {
      const answer = await ask();
      if (signal.aborted) return;
      changed(answer.tracks);
      // unchanged tracks have changed elsewhere: show their present state
      if (answer.stayed > 0) anew();
    } catch (thrown) {
      if (!signal.aborted) toast(sentence(thrown), { tone: 'bad', topic: 'search' });
    } finally {
      busy = false;
      if (!signal.aborted) show(selected().length);
    }
  }

  /** @param {TracksDone} answer @param {string} text @param {boolean} undoable */
  function tell(answer, text, undoable) {
    const stayed =
      answer.stayed === 0
        ? ''
        : ` ${plural(answer.stayed, 'track')} stayed: ${answer.sentences.slice(0, 3).join(' ')}${answer.stayed > 3 ? ` And ${count(answer.stayed - 3)} more.` : ''}`;
    toast(text + stayed, {
      tone: answer.stayed > 0 ? 'bad' : 'good',
      topic: 'search',
      action: undoable ? { label: 'Undo', run: () => void undo() } : undefined,
    });
  }

  async function relabel() {
    const tracks = selected();
    if (tracks.length === 0) return;
    const sets = new Set(tracks.map(({ label }) => label?.set).filter((set) => set !== undefined));
    try {
      const [only] = sets;
      const labels = sets.size === 1 ? await api.labelsOfSet(String(only), { signal }) : store.get().labels;
      store.dispatch(openDialog, {
        kind: 'choose-label',
        data: {
          title: `Label of ${plural(tracks.length, 'track')}`,
          labels,
          take: (/** @type {import('../../types.js').Label} */ label) =>
            void act({ type: 'relabel', label: label.key }, `Relabelled ${label.name}`),
        },
      });
    } catch (thrown) {
      if (!signal.aborted) toast(sentence(thrown), { tone: 'bad', topic: 'search' });
    }
  }

  function tag() {
    const tracks = selected();
    if (tracks.length === 0) return;
    const videos = [...new Set(tracks.map(({ video }) => video))];
    const known = [...new Set(tracks.flatMap(({ tags }) => tags))].sort();
    store.dispatch(openDialog, { kind: 'tags', data: { videos, known, done: anew } });
  }

  async function exportThem() {
    const found = selected();
    if (found.length === 0) return;
    /** @type {Record<string, string[]>} */
    const tracks = {};
    for (const { run, key } of found) (tracks[run] ??= []).push(key);
    const videos = new Map(found.map(({ run, video }) => [run, video]));
    if (new Set(videos.values()).size < videos.size) {
      toast('The selected tracks belong to two runs of one video, which one export cannot contain. Select tracks of one run per video.', {
        tone: 'bad',
        topic: 'search',
      });
      return;
    }
    try {
      // the dialog lists only runs of known videos
      for (const video of videos.values()) {
        if (!store.get().runs[video])
          await app.load(
            () => api.runs(video, { signal }),
            (state, runs) => setRuns(state, video, runs),
          );
      }
    } catch (thrown) {
      if (!signal.aborted) toast(sentence(thrown), { tone: 'bad', topic: 'search' });
      return;
    }
    store.dispatch(openDialog, { kind: 'export', data: { runs: Object.keys(tracks), tracks } });
  }

  const ignored = () => selected().length > 0 && selected().every(({ state }) => state === 'ignored');
  /** @type {{key: string, label: string, title: string, icon: import('../icons.js').IconName, run: () => void, free?: boolean}[]} */
  const offers = [
    {
      key: 'A',
      label: 'Accept',
      title: 'Accept the selected tracks (A)',
      icon: 'accept',
      run: () => void act({ type: 'judge', review: 'accepted' }, 'Accepted'),
    },
    {
      key: 'X',
      label: 'False positive',
      title: 'The selected tracks are not signs (X)',
      icon: 'reject',
      run: () => void act({ type: 'judge', review: 'rejected' }, 'False positives'),
    },
    {
      key: 'W',
      label: 'Needs work',
      title: 'The selected tracks need work (W)',
      icon: 'needs_work',
      run: () => void act({ type: 'judge', review: 'needs_work' }, 'Needs work'),
    },
    {
      key: 'I',
      label: 'Ignore',
      title: 'Ignore the selected tracks, or count them again (I)',
      icon: 'ignore',
      run: () =>
        void (ignored() ? act({ type: 'ignore', value: false }, 'Counted again') : act({ type: 'ignore', value: true }, 'Ignored')),
    },
    { key: 'L', label: 'Relabel', title: 'Give the selected tracks a label (L)', icon: 'label', run: () => void relabel() },
    { key: 'T', label: 'Tags', title: 'Tags of the videos of the selected tracks (T)', icon: 'note', run: tag },
    { key: 'E', label: 'Export', title: 'Export only the selected tracks (E)', icon: 'export', run: () => void exportThem() },
    { key: 'Enter', label: 'Open', title: 'Open the track at its frame (Enter)', icon: 'forward', run: open },
    { key: 'Ctrl+A', label: 'All', title: 'Select all found tracks (Ctrl+A); deselect all (Esc)', icon: 'select', run: all, free: true },
    { key: 'Ctrl+Z', label: 'Undo', title: 'Undo the last action here (Ctrl+Z)', icon: 'undo', run: () => void undo(), free: true },
  ];
  const buttons = offers.map((offer) =>
    h(
      'button.btn',
      { title: offer.title, 'aria-label': offer.label, onclick: offer.run },
      icon(offer.icon),
      h('span.search-act', offer.label),
    ),
  );
  const element = h('div.search-actions', { role: 'toolbar', 'aria-label': 'Selected tracks' }, ...buttons);

  /** @param {number} number   number of selected tracks */
  function show(number) {
    offers.forEach((offer, i) => {
      buttons[i].disabled = busy || (offer.label === 'Undo' ? done.length === 0 : !offer.free && number === 0);
      if (offer.key === 'I') setText(/** @type {Element} */ (buttons[i].lastElementChild), ignored() ? 'Count again' : 'Ignore');
    });
  }
  show(0);

  return {
    element,
    show,
    /** @param {KeyboardEvent} event @returns {boolean} whether the key was handled here */
    key(event) {
      const control = event.ctrlKey || event.metaKey;
      if (event.altKey || event.shiftKey || event.repeat) return false;
      if (event.key === 'Escape') {
        none();
        return true;
      }
      const name = `${control ? 'Ctrl+' : ''}${event.key.length === 1 ? event.key.toUpperCase() : event.key}`;
      const at = offers.findIndex(({ key }) => key === name && key !== 'Enter');
      if (at < 0) return false;
      if (!buttons[at].disabled) offers[at].run();
      else if (!busy && name !== 'Ctrl+Z') toast('Select tracks first: click one, or Space.', { topic: 'search' });
      return true;
    },
  };
}

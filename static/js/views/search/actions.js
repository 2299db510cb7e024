// @ts-check
/** Actions on the selected tracks: one operation per run, and one undo for all. */

import { errorMessage } from '../../api/errors.js';
import { openDialog, setRuns } from '../../store/actions/page.js';
import { h, setText } from '../dom.js';
import { count, plural } from '../../model/format.js';
import { icon } from '../icons.js';
import { authorName } from '../../core/preferences.js';
import { toast } from '../../core/toast.js';
import { randomId } from '../../core/random_id.js';

/** @typedef {import('../../types.js').FoundTrack} FoundTrack */
/** @typedef {import('../../api/search.js').TrackAction} TrackAction */
/** @typedef {import('../../api/search.js').TracksDone} TracksDone */

/**
 * @param {import('../../page-types.js').App} app
 * @param {object} setup
 * @param {() => FoundTrack[]} setup.selected
 * @param {(tracks: FoundTrack[]) => void} setup.onChange   the tracks after the action
 * @param {() => void} setup.repeatSearch                   search again
 * @param {() => void} setup.openTrack
 * @param {() => void} setup.selectAll
 * @param {() => void} setup.selectNone
 * @param {AbortSignal} setup.signal
 */
export function createSearchActions(app, { selected, onChange, repeatSearch, openTrack, selectAll, selectNone, signal }) {
  const { store, api } = app;
  /** Actions that can be undone, newest last. @type {{operations: TracksDone['operations'], description: string}[]} */
  const undoStack = [];
  let busy = false;
  const author = () => authorName(store.get().session) || store.get().session?.author || null;

  /** @param {TrackAction} action @param {string} description   begins a sentence */
  async function applyAction(action, description) {
    const tracks = selected();
    if (tracks.length === 0 || busy) return;
    await runRequest(async () => {
      const trackRefs = tracks.map(({ run, key, revision }) => ({ run, key, revision }));
      const answer = await api.actOnTracks({ action_id: randomId(), author: author(), action, tracks: trackRefs }, { signal });
      if (answer.operations.length > 0) undoStack.push({ operations: answer.operations, description });
      const text =
        answer.changed > 0
          ? `${description}: ${plural(answer.changed, 'track')} in ${plural(answer.operations.length, 'run')}.`
          : answer.stayed > 0
            ? 'Nothing was changed.'
            : 'Nothing changes: the tracks already have this value.';
      showResult(answer, text, answer.operations.length > 0);
      return answer;
    });
  }

  async function undo() {
    const last = undoStack.at(-1);
    if (!last) {
      toast('There is nothing left to undo here.', { topic: 'search' });
      return;
    }
    if (busy) return;
    await runRequest(async () => {
      const answer = await api.undoTracks({ author: author(), operations: last.operations }, { signal });
      undoStack.splice(undoStack.indexOf(last), 1);
      showResult(answer, `Undone: ${last.description.toLowerCase()}, ${plural(answer.changed, 'track')}.`, false);
      return answer;
    });
  }

  /** @param {() => Promise<TracksDone>} request */
  async function runRequest(request) {
    busy = true;
    show(selected().length);
    try {
      const answer = await request();
      if (signal.aborted) return;
      onChange(answer.tracks);
      // unchanged tracks have changed elsewhere: show their present state
      if (answer.stayed > 0) repeatSearch();
    } catch (thrown) {
      if (!signal.aborted) toast(errorMessage(thrown), { tone: 'bad', topic: 'search' });
    } finally {
      busy = false;
      if (!signal.aborted) show(selected().length);
    }
  }

  /** @param {TracksDone} answer @param {string} text @param {boolean} undoable */
  function showResult(answer, text, undoable) {
    const unchangedText =
      answer.stayed === 0
        ? ''
        : ` ${plural(answer.stayed, 'track')} stayed: ${answer.sentences.slice(0, 3).join(' ')}${answer.stayed > 3 ? ` And ${count(answer.stayed - 3)} more.` : ''}`;
    toast(text + unchangedText, {
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
      const [singleSet] = sets;
      const labels = sets.size === 1 ? await api.labelsOfSet(String(singleSet), { signal }) : store.get().labels;
      store.dispatch(openDialog, {
        kind: 'choose-label',
        data: {
          title: `Label of ${plural(tracks.length, 'track')}`,
          labels,
          take: (/** @type {import('../../types.js').Label} */ label) =>
            void applyAction({ type: 'relabel', label: label.key }, `Relabelled ${label.name}`),
        },
      });
    } catch (thrown) {
      if (!signal.aborted) toast(errorMessage(thrown), { tone: 'bad', topic: 'search' });
    }
  }

  function tag() {
    const tracks = selected();
    if (tracks.length === 0) return;
    const videos = [...new Set(tracks.map(({ video }) => video))];
    const known = [...new Set(tracks.flatMap(({ tags }) => tags))].sort();
    store.dispatch(openDialog, { kind: 'tags', data: { videos, known, done: repeatSearch } });
  }

  async function exportSelected() {
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
      if (!signal.aborted) toast(errorMessage(thrown), { tone: 'bad', topic: 'search' });
      return;
    }
    store.dispatch(openDialog, { kind: 'export', data: { runs: Object.keys(tracks), tracks } });
  }

  const areAllIgnored = () => selected().length > 0 && selected().every(({ state }) => state === 'ignored');
  /** @type {{key: string, label: string, title: string, icon: import('../icons.js').IconName, run: () => void, free?: boolean}[]} */
  const commands = [
    {
      key: 'A',
      label: 'Accept',
      title: 'Accept the selected tracks (A)',
      icon: 'accept',
      run: () => void applyAction({ type: 'judge', review: 'accepted' }, 'Accepted'),
    },
    {
      key: 'X',
      label: 'False positive',
      title: 'The selected tracks are not signs (X)',
      icon: 'reject',
      run: () => void applyAction({ type: 'judge', review: 'rejected' }, 'False positives'),
    },
    {
      key: 'W',
      label: 'Needs work',
      title: 'The selected tracks need work (W)',
      icon: 'needs_work',
      run: () => void applyAction({ type: 'judge', review: 'needs_work' }, 'Needs work'),
    },
    {
      key: 'I',
      label: 'Ignore',
      title: 'Ignore the selected tracks, or count them again (I)',
      icon: 'ignore',
      run: () =>
        void (areAllIgnored()
          ? applyAction({ type: 'ignore', value: false }, 'Counted again')
          : applyAction({ type: 'ignore', value: true }, 'Ignored')),
    },
    { key: 'L', label: 'Relabel', title: 'Give the selected tracks a label (L)', icon: 'label', run: () => void relabel() },
    { key: 'T', label: 'Tags', title: 'Tags of the videos of the selected tracks (T)', icon: 'note', run: tag },
    { key: 'E', label: 'Export', title: 'Export only the selected tracks (E)', icon: 'export', run: () => void exportSelected() },
    { key: 'Enter', label: 'Open', title: 'Open the track at its frame (Enter)', icon: 'forward', run: openTrack },
    {
      key: 'Ctrl+A',
      label: 'All',
      title: 'Select all found tracks (Ctrl+A); deselect all (Esc)',
      icon: 'select',
      run: selectAll,
      free: true,
    },
    { key: 'Ctrl+Z', label: 'Undo', title: 'Undo the last action here (Ctrl+Z)', icon: 'undo', run: () => void undo(), free: true },
  ];
  const buttons = commands.map((command) =>
    h(
      'button.btn',
      { title: command.title, 'aria-label': command.label, onclick: command.run },
      icon(command.icon),
      h('span.search-act', command.label),
    ),
  );
  const element = h('div.search-actions', { role: 'toolbar', 'aria-label': 'Selected tracks' }, ...buttons);

  /** @param {number} number   number of selected tracks */
  function show(number) {
    commands.forEach((command, i) => {
      buttons[i].disabled = busy || (command.label === 'Undo' ? undoStack.length === 0 : !command.free && number === 0);
      if (command.key === 'I') setText(/** @type {Element} */ (buttons[i].lastElementChild), areAllIgnored() ? 'Count again' : 'Ignore');
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
        selectNone();
        return true;
      }
      const name = `${control ? 'Ctrl+' : ''}${event.key.length === 1 ? event.key.toUpperCase() : event.key}`;
      const at = commands.findIndex(({ key }) => key === name && key !== 'Enter');
      if (at < 0) return false;
      if (!buttons[at].disabled) commands[at].run();
      else if (!busy && name !== 'Ctrl+Z') toast('Select tracks first: click one, or Space.', { topic: 'search' });
      return true;
    },
  };
}

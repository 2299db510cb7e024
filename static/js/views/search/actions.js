// @ts-check
/** Actions on the selected tracks: one operation per run, and one undo for all. */

import { errorMessage } from '../../api/errors.js';
import { openDialog } from '../../store/actions/page.js';
import { h, setText } from '../dom.js';
import { count, plural } from '../../model/format.js';
import { icon } from '../icons.js';
import { authorName } from '../../core/preferences.js';
import { toast } from '../../core/toast.js';
import { randomId } from '../../core/random_id.js';
import { loadMissingRuns } from '../load_runs.js';

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
          take: (label) => void applyAction({ type: 'relabel', label: label.key }, `Relabelled ${label.name}`),
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
    /** @type {Record<string, string[]>} */ const tracks = {};
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
      for (const video of videos.values()) await loadMissingRuns(app, video, { signal });
    } catch (thrown) {
      if (!signal.aborted) toast(errorMessage(thrown), { tone: 'bad', topic: 'search' });
      return;
    }
    store.dispatch(openDialog, { kind: 'export', data: { runs: Object.keys(tracks), tracks } });
  }

  const areAllIgnored = () => selected().length > 0 && selected().every(({ state }) => state === 'ignored');
  const toggleIgnored = () =>
    void (areAllIgnored()
      ? applyAction({ type: 'ignore', value: false }, 'Counted again')
      : applyAction({ type: 'ignore', value: true }, 'Ignored'));
  /** @param {'accepted'|'rejected'|'needs_work'} review @param {string} description */
  const judge = (review, description) => void applyAction({ type: 'judge', review }, description);
  /** Key, name, tooltip, icon and effect. @type {[key: string, label: string, title: string, icon: import('../icons.js').IconName, run: () => void][]} */
  const commands = [
    ['A', 'Accept', 'Accept the selected tracks (A)', 'accept', () => judge('accepted', 'Accepted')],
    ['X', 'False positive', 'The selected tracks are not signs (X)', 'reject', () => judge('rejected', 'False positives')],
    ['W', 'Needs work', 'The selected tracks need work (W)', 'needs_work', () => judge('needs_work', 'Needs work')],
    ['I', 'Ignore', 'Ignore the selected tracks, or count them again (I)', 'ignore', toggleIgnored],
    ['L', 'Relabel', 'Give the selected tracks a label (L)', 'label', () => void relabel()],
    ['T', 'Tags', 'Tags of the videos of the selected tracks (T)', 'note', tag],
    ['E', 'Export', 'Export only the selected tracks (E)', 'export', () => void exportSelected()],
    ['Enter', 'Open', 'Open the track at its frame (Enter)', 'forward', openTrack],
    ['Ctrl+A', 'All', 'Select all found tracks (Ctrl+A); deselect all (Esc)', 'select', selectAll],
    ['Ctrl+Z', 'Undo', 'Undo the last action here (Ctrl+Z)', 'undo', () => void undo()],
  ];
  const buttons = commands.map(([, label, title, name, run]) =>
    h('button.btn', { title, 'aria-label': label, onclick: run }, icon(name), h('span.search-act', label)),
  );
  const element = h('div.search-actions', { role: 'toolbar', 'aria-label': 'Selected tracks' }, ...buttons);

  /** @param {number} number   number of selected tracks */
  function show(number) {
    commands.forEach(([key], i) => {
      buttons[i].disabled = busy || (key === 'Ctrl+Z' ? undoStack.length === 0 : key !== 'Ctrl+A' && number === 0);
      if (key === 'I') setText(/** @type {Element} */ (buttons[i].lastElementChild), areAllIgnored() ? 'Count again' : 'Ignore');
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
      const at = commands.findIndex(([key]) => key === name && key !== 'Enter');
      if (at < 0) return false;
      if (!buttons[at].disabled) commands[at][4]();
      else if (!busy && name !== 'Ctrl+Z') toast('Select tracks first: click one, or Space.', { topic: 'search' });
      return true;
    },
  };
}

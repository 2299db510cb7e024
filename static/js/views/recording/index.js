// @ts-check
/**
 * The recording of the current run around the current frame, in the Rerun viewer.
 *
 * Time cursor and selection follow the review screen and vice versa. If the viewer cannot be shown, the file is offered
 * for download.
 */

import { seek, select } from '../../store/actions/review.js';
import { fill, h, reconcile, setText } from '../dom.js';
import { emptyState, errorState, loadingState } from '../placeholders.js';
import { pollUntilFinished } from '../poll_output.js';
import { count, plural } from '../../model/format.js';
import { icon } from '../icons.js';
import { isActive } from '../output_text.js';
import { createRecordingApi } from './api.js';
import { covers, rangeAround, recordingFor, storedFrames } from './ranges.js';
import { correctedKeysInOrder, entityOf, trackOf } from './selection.js';
import { createEmbeddedViewer } from './embedded_viewer.js';

/** @typedef {import('../../state-types.js').State} State */
/** @typedef {import('./api.js').Recording} Recording */

/** Interval of requests while a recording is being made, ms. */
const POLL_INTERVAL_MS = 400;

/** @type {import('../../page-types.js').CreateView} */
export function createRecordingView(app) {
  const lifetime = new AbortController();
  const signal = AbortSignal.any([lifetime.signal, app.signal]);
  const api = createRecordingApi({ base: app.api.base, signal });
  /** @type {State|null} */ let state = null;
  /** Id of the run whose recordings are listed. @type {string|null} */
  let run = null;
  /** @type {Recording[]|null} */ let recordings = null;
  /** The recording that is shown or being made. @type {Recording|null} */
  let current = null;
  /** @type {import('./embedded_viewer.js').EmbeddedViewer|null} */ let viewer = null;
  /** The last selection from the viewer, which is not sent back to it. @type {string|null} */
  let selectedInViewer = null;
  /** @type {string|null} */ let sentSelection = null;
  /** The frames of the button that makes a recording. @type {import('./ranges.js').Range|null} */
  let offeredRange = null;

  const recordingSelect = h('select.input.recording-choose', {
    'aria-label': 'Recording',
    onchange: () => {
      const chosen = recordings?.find(({ id }) => id === recordingSelect.value);
      if (chosen) void show(chosen);
    },
  });
  const recordButton = h('button.btn', { onclick: () => void make() }, icon('film'), 'Record around this frame');
  const downloadLink = h(
    'a.btn',
    { download: '', hidden: true, title: 'Opens in a stand-alone viewer of the same version: rerun FILE.rrd' },
    'Download',
  );
  const notice = h('p.recording-notice.small', { role: 'status' });
  const body = h('div.recording-body');
  const element = h('div.recording', h('div.recording-bar', recordingSelect, recordButton, downloadLink, notice), body);

  const frame = () => state?.review?.frame ?? 0;

  /** @param {unknown} thrown @param {() => void} [retry] */
  function showError(thrown, retry) {
    if (signal.aborted) return;
    closeViewer();
    fill(body, errorState('The recording cannot be shown', thrown, retry));
  }

  function closeViewer() {
    viewer?.destroy();
    viewer = null;
    selectedInViewer = sentSelection = null;
  }

  /** @param {string} id   id of the run */
  async function load(id) {
    run = id;
    recordings = current = null;
    closeViewer();
    fill(body, loadingState('Loading the recordings', { signal }));
    try {
      const found = await api.list(id);
      if (run !== id || signal.aborted) return;
      recordings = found;
      const matching = recordingFor(found, frame()) ?? found.find(isActive) ?? null;
      if (matching) void show(matching);
      else offerRecording();
    } catch (thrown) {
      if (run === id) showError(thrown, () => void load(id));
    }
    refresh();
  }

  function offerRecording() {
    closeViewer();
    current = null;
    const range = rangeToRecord();
    offeredRange = range;
    fill(
      body,
      emptyState({
        icon: 'film',
        title: range ? 'No recording contains this frame yet' : 'The run has no frames yet',
        text: range
          ? `A recording contains the picture, all boxes, the gate's factors, votes and events of ${plural(range.stop - range.first, 'frame')} in one file, for the Rerun viewer. It takes a second or two.`
          : 'Wait until the first frames are stored.',
        actions: [
          range
            ? h('button.btn.btn-primary', { onclick: () => void make() }, `Record frames ${count(range.first)} to ${count(range.stop - 1)}`)
            : null,
        ],
      }),
    );
    refresh();
  }

  const rangeToRecord = () => (state?.review?.run ? rangeAround(frame(), storedFrames(state.review.run)) : null);

  async function make() {
    const range = rangeToRecord();
    const id = run;
    if (!range || !id) return;
    try {
      const created = await api.make(id, { ...range, frame: frame(), track: state?.review?.selected ?? null });
      if (run !== id || signal.aborted) return;
      recordings = [created, ...(recordings ?? [])];
      await show(created);
    } catch (thrown) {
      if (run === id) showError(thrown, () => void make());
    }
  }

  /** Show a recording as soon as it is complete. @param {Recording} recording */
  async function show(recording) {
    closeViewer();
    const id = run;
    current = recording;
    refresh();
    const isAbandoned = () => signal.aborted || run !== id || current?.id !== recording.id;
    try {
      if (isActive(recording)) fill(body, loadingState('Making the recording', { signal }));
      const finished = await pollUntilFinished(recording, api.get, { intervalMs: POLL_INTERVAL_MS, isAbandoned });
      if (finished === null) return;
      current = finished;
      recordings = (recordings ?? []).map((one) => (one.id === finished.id ? finished : one));
      refresh();
      if (finished.state !== 'complete') {
        showError(finished.error ?? 'The recording was cancelled.', () => void make());
        return;
      }
      fill(body, loadingState('Preparing the viewer', { signal, slowAfterMs: 60_000 }));
      const viewerState = await api.viewer();
      if (isAbandoned()) return;
      if (viewerState.ready) open(finished, viewerState.version);
      else offerDownload(finished, viewerState.message);
    } catch (thrown) {
      if (!isAbandoned()) showError(thrown, () => void show(recording));
    }
  }

  /** @param {Recording} recording @param {string} version */
  function open(recording, version) {
    const loadingVeil = h('div.recording-veil', loadingState('Starting the viewer', { signal, slowAfterMs: 60_000 }));
    viewer = createEmbeddedViewer({
      version,
      url: api.viewerUrl(recording.id),
      theme: document.documentElement.dataset.theme === 'light' ? 'light' : 'dark',
      frame: clamp(recording, frame()),
      onOpen: () => loadingVeil.remove(),
      onMove: (to) => {
        if (!app.store.get().review?.playing) app.store.dispatch(seek, to);
      },
      onSelect: (entity, instance) => {
        const review = app.store.get().review;
        const hasSameEdits = review && current?.summary?.edits === review.seq;
        const key = trackOf(entity, instance, review?.overlays[review.frame], hasSameEdits ? correctedKeysInOrder(review) : []);
        if (!review || key === null) return;
        selectedInViewer = key;
        if (key !== review.selected) app.store.dispatch(select, key);
      },
      onFail: (message) => offerDownload(recording, message),
    });
    fill(body, viewer.element, loadingVeil);
    syncViewer();
  }

  /** Offer the file if the viewer cannot be shown. @param {Recording} recording @param {string} message */
  function offerDownload(recording, message) {
    closeViewer();
    fill(
      body,
      emptyState({
        icon: 'film',
        title: 'The viewer cannot be shown here',
        text: `${message} The recording is complete: open the file in a stand-alone viewer with "rerun ${recording.name}".`,
        actions: [h('a.btn.btn-primary', { href: api.downloadUrl(recording.id), download: '' }, 'Download the recording')],
      }),
    );
  }

  /** Move the viewer to the frame and track of the review screen. */
  function syncViewer() {
    const review = state?.review;
    if (!viewer || !current || !review) return;
    if (covers(current.options, review.frame)) viewer.seek(review.frame);
    if (review.selected === null || review.selected === selectedInViewer) return;
    const entity = entityOf(review.selected, review.overlays[review.frame]);
    if (entity === null || review.selected === sentSelection) return;
    sentSelection = review.selected;
    selectedInViewer = null;
    viewer.select(entity);
  }

  function refresh() {
    const listed = (recordings ?? []).filter((one) => one.state === 'complete' || isActive(one));
    reconcile(
      recordingSelect,
      listed,
      ({ id }) => id,
      ({ id }) => h('option', { value: id }),
      (option, { options, state: recordingState }) => {
        setText(option, `Frames ${count(options.first)}–${count(options.stop - 1)}${recordingState === 'complete' ? '' : ' (being made)'}`);
      },
    );
    recordingSelect.hidden = listed.length === 0;
    recordingSelect.value = current?.id ?? '';
    downloadLink.hidden = current?.state !== 'complete';
    if (current && !downloadLink.hidden) downloadLink.href = api.downloadUrl(current.id);
    const isOutside = current !== null && !covers(current.options, frame());
    const range = rangeToRecord();
    recordButton.hidden = !range || (current === null && recordings !== null);
    recordButton.title = range ? `Record frames ${range.first} to ${range.stop - 1} of this run` : '';
    const withoutPicture = current !== null && !isSecureContext;
    setText(notice, isOutside ? `Frame ${count(frame())} is not in this recording.` : withoutPicture ? NEEDS_HTTPS : '');
  }

  /** Take recordings that were made or removed elsewhere on the page. @param {import('../../types.js').Output[]} outputs */
  function onOutputs(outputs) {
    if (recordings === null) return;
    const found = /** @type {any[]} */ (outputs.filter(({ kind, run_id: of }) => kind === 'recording' && of === run));
    const fingerprint = (/** @type {readonly {id: string, state: string}[]} */ list) =>
      list.map(({ id, state: recordingState }) => id + recordingState).join();
    if (fingerprint(found) === fingerprint(recordings)) return;
    recordings = found;
    if (current === null) refreshOffer();
    refresh();
  }

  return {
    element,
    update(next) {
      const before = state?.review;
      const reported = state?.outputs;
      state = next;
      const review = next.review;
      if (!review?.run) return;
      if (review.run.id !== run) {
        void load(review.run.id);
        return;
      }
      if (next.outputs && next.outputs !== reported) onOutputs(next.outputs);
      const moved = before?.frame !== review.frame;
      if (moved || before?.selected !== review.selected || before?.overlays !== review.overlays) syncViewer();
      if (moved || before?.run !== review.run) {
        if (current === null && recordings !== null && !body.querySelector('.empty-error')) refreshOffer();
        refresh();
      }
    },
    destroy() {
      lifetime.abort();
      closeViewer();
    },
  };

  /** Update the offer after a move of the cursor while nothing is shown: another recording may contain the frame. */
  function refreshOffer() {
    const matching = recordingFor(recordings ?? [], frame());
    if (matching) {
      void show(matching);
      return;
    }
    const range = rangeToRecord();
    if (range?.first !== offeredRange?.first || range?.stop !== offeredRange?.stop) offerRecording();
  }
}

const NEEDS_HTTPS =
  'Browsers decode video only on pages by HTTPS or from this machine, so the picture is missing here. The downloaded recording shows it.';

/** @param {Recording} recording @param {number} frame */
const clamp = ({ options }, frame) => Math.max(options.first, Math.min(options.stop - 1, frame));

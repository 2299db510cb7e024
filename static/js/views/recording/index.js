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
import { covers, storedFrames, rangeAround, recordingFor } from './ranges.js';
import { entityOf, correctedKeysInOrder, trackOf } from './selection.js';
import { createEmbeddedViewer } from './embedded_viewer.js';

/** @typedef {import('../../state-types.js').State} State */
/** @typedef {import('./api.js').Recording} Recording */

/** Interval of requests while a recording is being made, ms. */
const LOOK = 400;

/**
 * @param {import('../../page-types.js').App} app
 * @returns {import('../../page-types.js').View}
 */
export function createRecordingView(app) {
  const ended = new AbortController();
  const signal = AbortSignal.any([ended.signal, app.signal]);
  const api = createRecordingApi({ base: app.api.base, signal });
  /** @type {State|null} */
  let state = null;
  /** Id of the run whose recordings are listed. @type {string|null} */
  let run = null;
  /** @type {Recording[]|null} */
  let recordings = null;
  /** The recording that is shown or being made. @type {Recording|null} */
  let current = null;
  /** @type {import('./embedded_viewer.js').EmbeddedViewer|null} */
  let stage = null;
  /** The last selection from the viewer, which is not sent back to it. @type {string|null} */
  let picked = null;
  /** @type {string|null} */
  let sent = null;
  /** @type {{frame: number, stop: number}|null} */
  let offered = null;

  const choose = h('select.input.recording-choose', {
    'aria-label': 'Recording',
    onchange: () => {
      const chosen = recordings?.find(({ id }) => id === choose.value);
      if (chosen) void show(chosen);
    },
  });
  const record = h('button.btn', { onclick: () => void make() }, icon('film'), 'Record around this frame');
  const download = h(
    'a.btn',
    { download: '', hidden: true, title: 'Opens in a stand-alone viewer of the same version: rerun FILE.rrd' },
    'Download',
  );
  const notice = h('p.recording-notice.small', { role: 'status' });
  const body = h('div.recording-body');
  const element = h('div.recording', h('div.recording-bar', choose, record, download, notice), body);

  const frame = () => state?.review?.frame ?? 0;

  /** @param {unknown} thrown @param {() => void} [retry] */
  function failed(thrown, retry) {
    if (signal.aborted) return;
    leave();
    fill(body, errorState('The recording cannot be shown', thrown, retry));
  }

  function leave() {
    stage?.destroy();
    stage = null;
    picked = sent = null;
  }

  /** @param {string} id   id of the run */
  async function load(id) {
    run = id;
    recordings = current = null;
    leave();
    fill(body, loadingState('Loading the recordings', { signal }));
    try {
      const found = await api.list(id);
      if (run !== id || signal.aborted) return;
      recordings = found;
      const fitting = recordingFor(found, frame()) ?? found.find(isActive) ?? null;
      if (fitting) void show(fitting);
      else offer();
    } catch (thrown) {
      if (run === id) failed(thrown, () => void load(id));
    }
    refresh();
  }

  function offer() {
    leave();
    current = null;
    const range = wanted();
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

  const wanted = () => (state?.review?.run ? rangeAround(frame(), storedFrames(state.review.run)) : null);

  async function make() {
    const range = wanted();
    const id = run;
    if (!range || !id) return;
    try {
      const made = await api.make(id, { ...range, frame: frame(), track: state?.review?.selected ?? null });
      if (run !== id || signal.aborted) return;
      recordings = [made, ...(recordings ?? [])];
      await show(made);
    } catch (thrown) {
      if (run === id) failed(thrown, () => void make());
    }
  }

  /** Show a recording as soon as it is complete. @param {Recording} recording */
  async function show(recording) {
    leave();
    const id = run;
    current = recording;
    refresh();
    const left = () => signal.aborted || run !== id || current?.id !== recording.id;
    try {
      if (isActive(recording)) fill(body, loadingState('Making the recording', { signal }));
      const now = await pollUntilFinished(recording, api.get, { intervalMs: LOOK, isAbandoned: left });
      if (now === null) return;
      current = now;
      recordings = (recordings ?? []).map((one) => (one.id === now.id ? now : one));
      refresh();
      if (now.state !== 'complete') {
        failed(now.error ?? 'The recording was cancelled.', () => void make());
        return;
      }
      fill(body, loadingState('Preparing the viewer', { signal, slowAfterMs: 60_000 }));
      const viewer = await api.viewer();
      if (left()) return;
      if (viewer.ready) open(now, viewer.version);
      else instead(now, viewer.message);
    } catch (thrown) {
      if (!left()) failed(thrown, () => void show(recording));
    }
  }

  /** @param {Recording} recording @param {string} version */
  function open(recording, version) {
    const veil = h('div.recording-veil', loadingState('Starting the viewer', { signal, slowAfterMs: 60_000 }));
    stage = createEmbeddedViewer({
      version,
      url: api.viewerUrl(recording.id),
      theme: document.documentElement.dataset.theme === 'light' ? 'light' : 'dark',
      frame: clamp(recording, frame()),
      onOpen: () => veil.remove(),
      onMove: (to) => {
        if (!app.store.get().review?.playing) app.store.dispatch(seek, to);
      },
      onSelect: (entity, instance) => {
        const review = app.store.get().review;
        const same = review && current?.summary?.edits === review.seq;
        const key = trackOf(entity, instance, review?.overlays[review.frame], same ? correctedKeysInOrder(review) : []);
        if (!review || key === null) return;
        picked = key;
        if (key !== review.selected) app.store.dispatch(select, key);
      },
      onFail: (message) => instead(recording, message),
    });
    fill(body, stage.element, veil);
    follow();
  }

  /** Offer the file if the viewer cannot be shown. @param {Recording} recording @param {string} message */
  function instead(recording, message) {
    leave();
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
  function follow() {
    const review = state?.review;
    if (!stage || !current || !review) return;
    if (covers(current.options, review.frame)) stage.seek(review.frame);
    if (review.selected === null || review.selected === picked) return;
    const entity = entityOf(review.selected, review.overlays[review.frame]);
    if (entity === null || review.selected === sent) return;
    sent = review.selected;
    picked = null;
    stage.select(entity);
  }

  function refresh() {
    const listed = (recordings ?? []).filter((one) => one.state === 'complete' || isActive(one));
    reconcile(
      choose,
      listed,
      ({ id }) => id,
      ({ id }) => h('option', { value: id }),
      (option, { options, state: how }) => {
        setText(option, `Frames ${count(options.first)}–${count(options.stop - 1)}${how === 'complete' ? '' : ' (being made)'}`);
      },
    );
    choose.hidden = listed.length === 0;
    choose.value = current?.id ?? '';
    download.hidden = current?.state !== 'complete';
    if (current && !download.hidden) download.href = api.downloadUrl(current.id);
    const outside = current !== null && !covers(current.options, frame());
    const range = wanted();
    record.hidden = !range || (current === null && recordings !== null);
    record.title = range ? `Record frames ${range.first} to ${range.stop - 1} of this run` : '';
    setText(notice, outside ? `Frame ${count(frame())} is not in this recording.` : '');
  }

  /** Take recordings that were made or removed elsewhere on the page. @param {import('../../types.js').Output[]} outputs */
  function receive(outputs) {
    if (recordings === null) return;
    const found = /** @type {any[]} */ (outputs.filter(({ kind, run_id: of }) => kind === 'recording' && of === run));
    const news = (/** @type {readonly {id: string, state: string}[]} */ list) => list.map(({ id, state: how }) => id + how).join();
    if (news(found) === news(recordings)) return;
    recordings = found;
    if (current === null) reoffer();
    refresh();
  }

  return {
    element,
    update(next) {
      const before = state?.review;
      const reported = state?.outputs;
      state = next;
      const now = next.review;
      if (!now?.run) return;
      if (now.run.id !== run) {
        void load(now.run.id);
        return;
      }
      if (next.outputs && next.outputs !== reported) receive(next.outputs);
      const moved = before?.frame !== now.frame;
      if (moved || before?.selected !== now.selected || before?.overlays !== now.overlays) follow();
      if (moved || before?.run !== now.run) {
        if (current === null && recordings !== null && !body.querySelector('.empty-error')) reoffer();
        refresh();
      }
    },
    destroy() {
      ended.abort();
      leave();
      element.remove();
    },
  };

  /** Update the offer after a move of the cursor while nothing is shown: another recording may contain the frame. */
  function reoffer() {
    const fitting = recordingFor(recordings ?? [], frame());
    if (fitting) {
      void show(fitting);
      return;
    }
    const range = wanted();
    if (range?.first === offered?.frame && range?.stop === offered?.stop) return;
    offered = range && { frame: range.first, stop: range.stop };
    offer();
  }
}

/** @param {Recording} recording @param {number} frame */
const clamp = ({ options }, frame) => Math.max(options.first, Math.min(options.stop - 1, frame));

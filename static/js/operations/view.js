// @ts-check
/** Layers, zoom, history. */

import { plural } from '../model/format.js';
import { sizeOf, zoomToBox } from '../model/geometry.js';
import { formatRoute } from '../model/route.js';
import { selectedTrack } from '../review/shown_tracks.js';
import { LAYERS } from '../store/initial.js';
import { changeLanesView, openDialog } from '../store/actions/page.js';
import { setViewport, toggleFewLabels, toggleLayer } from '../store/actions/review.js';
import { unsavedOf } from '../store/unsaved.js';
import { SUB_LANES } from '../model/sub_lanes.js';
import { toast } from '../core/toast.js';
import { needsBox, needsRun, onReview, operation } from './helpers.js';

/** Side of a box after "Zoom to the track", screen px. */
const ZOOMED_BOX_SIDE_PX = 140;

/** Names of the layers. */
export const LAYER_NAMES = /** @type {const} */ ({
  detections: 'Offline detections',
  predictions: 'Kalman predictions',
  search: 'Search regions',
  relocalisations: 'Re-detected by the online detector',
  results: 'Results',
  corrected: 'Corrected annotation',
  truth: 'Ground truth',
  second: 'Second run',
  uncertainty: 'Uncertainty box: the 1-sigma area of the predicted centre',
  gate: 'Gate value of each track (lower is better)',
});

/** Key of a layer. @param {import('../state-types.js').LayerName} name */
export const layerKey = (name) => (name === 'gate' ? 'Shift+9' : String(LAYERS.indexOf(name) + 1));

/** Short names for the legend. */
export const SHORT_NAMES = /** @type {const} */ ({
  detections: 'Detections',
  predictions: 'Predictions',
  search: 'Search',
  relocalisations: 'Re-detected',
  results: 'Results',
  corrected: 'Corrected',
  truth: 'Truth',
  second: 'Second run',
  uncertainty: 'Uncertainty box',
  gate: 'Gate value',
});

/**
 * Show or hide a layer. The layer of the second run first needs a choice of the run.
 * @param {import('../state-types.js').State} state
 * @param {import('../state-types.js').LayerName} name
 */
export const switchLayer = (state, name) =>
  name === 'second' && state.review !== null && state.review.second === null
    ? openDialog(state, { kind: 'second' })
    : toggleLayer(state, name);

/** @type {import('../page-types.js').Operation[]} */
export const view = [
  operation({
    id: 'undo',
    label: 'Undo',
    keys: ['Ctrl+Z'],
    icon: 'undo',
    group: 'History',
    repeats: true,
    disabled: (state) => (state.review?.undo ? null : 'There is nothing to undo.'),
    run: (app) => app.editor.undo(),
  }),
  operation({
    id: 'redo',
    label: 'Redo',
    keys: ['Ctrl+Shift+Z', 'Ctrl+Y'],
    icon: 'redo',
    group: 'History',
    repeats: true,
    disabled: (state) => (state.review?.redo ? null : 'There is nothing to redo.'),
    run: (app) => app.editor.redo(),
  }),
  operation({
    id: 'save',
    label: 'Save',
    keys: ['Ctrl+S'],
    group: 'History',
    tooltip: 'Every change is saved when it is made; this shows the state (Ctrl+S)',
    available: (state) => onReview(state) || state.elsewhere.length > 0,
    run: async (app) => {
      app.editor.retry();
      const { unsaved, held } = unsavedOf(app.store.get());
      const sent = unsaved - held;
      if (sent > 0) toast(`${plural(sent, 'change')} ${sent === 1 ? 'is' : 'are'} on the way to the server.`);
      await app.editor.settled();
      const left = unsavedOf(app.store.get());
      if (left.unsaved === 0) toast('Everything is saved.', { tone: 'good' });
      else if (left.held) toast(`${plural(left.held, 'change')} ${left.held === 1 ? 'waits' : 'wait'} for your decision.`);
    },
  }),
  operation({
    id: 'open-undecided',
    label: 'Open the run with a conflict',
    keys: [],
    group: 'History',
    tooltip: 'Somebody else changed a track first, in a run that is not open: see both versions and choose one',
    available: (state) => state.elsewhere.some(({ held }) => held),
    run: async (app) => {
      const one = app.store.get().elsewhere.find(({ held }) => held);
      if (!one) return;
      const { video_id } = await app.api.run(one.run);
      location.hash = formatRoute({ screen: 'review', video: video_id, run: one.run, frame: null, track: null });
    },
  }),
  operation({
    id: 'decide-conflict',
    label: 'Decide on a conflict',
    keys: [],
    group: 'History',
    tooltip: 'Somebody else changed a track first: see both versions and choose one',
    disabled: (state) => (state.banners.some(({ id }) => id === 'conflict') ? null : 'There is no conflict.'),
    run: (app) => app.editor.decide(),
  }),
  operation({
    id: 'carry-over',
    label: 'Carry over corrections of an earlier run',
    keys: [],
    group: 'History',
    tooltip: 'Each correction is applied to this run, skipped if this run already has it, or reported as a conflict',
    disabled: (state) => (state.review?.earlier ? null : 'No earlier run has corrections that this one lacks.'),
    run: (app) =>
      app.store.dispatch((state) => {
        const { review } = state;
        const from = review && state.runs[review.video.id]?.find(({ id }) => id === review.earlier?.run_id);
        return from && review.run ? openDialog(state, { kind: 'adopted', data: { from, to: review.run, now: true } }) : state;
      }),
  }),
  ...LAYERS.map((name) =>
    operation({
      id: `layer-${name}`,
      label: LAYER_NAMES[name],
      keys: [layerKey(name)],
      group: 'Layers',
      tooltip: `Show or hide: ${LAYER_NAMES[name]} (${layerKey(name)})`,
      run: (app) => app.store.dispatch(switchLayer, name),
    }),
  ),
  operation({
    id: 'second-run',
    label: 'Choose the second run …',
    keys: ['Shift+8'],
    group: 'Layers',
    disabled: needsRun,
    run: (app) => app.store.dispatch(openDialog, { kind: 'second' }),
  }),
  operation({
    id: 'fit',
    label: 'Whole picture',
    keys: ['0'],
    icon: 'fit',
    group: 'Picture',
    run: (app) => app.store.dispatch(setViewport, { zoom: 0, x: 0, y: 0 }),
  }),
  operation({
    id: 'actual-size',
    label: 'One to one (1:1)',
    short: '1:1',
    keys: ['Shift+0'],
    icon: 'one_to_one',
    group: 'Picture',
    run: (app) =>
      app.store.dispatch((state) =>
        state.review ? setViewport(state, { ...state.review.viewport, zoom: 1 / (globalThis.devicePixelRatio || 1) }) : state,
      ),
  }),
  operation({
    id: 'zoom-track',
    label: 'Zoom to the track',
    short: 'Zoom',
    keys: ['Z'],
    icon: 'zoom_in',
    group: 'Picture',
    disabled: needsBox,
    tooltip: 'Zoom to the selected track; the next tracks of the queue are then centred too (Z)',
    run: (app) =>
      app.store.dispatch((state) => {
        const shown = selectedTrack(state.review);
        return shown ? setViewport(state, zoomToBox(shown.box, ZOOMED_BOX_SIDE_PX, sizeOf(state.review?.video))) : state;
      }),
  }),
  operation({
    id: 'few-labels',
    label: 'Fewer names in the picture',
    short: 'Fewer names',
    keys: ['H'],
    icon: 'eye',
    group: 'Picture',
    tooltip: 'Name only the selected track and the one under the pointer, or all again (H)',
    run: (app) => app.store.dispatch(toggleFewLabels),
  }),
  operation({
    id: 'fold-lanes',
    label: 'All lanes, or only the chosen one',
    keys: ['Shift+L'],
    group: 'Lanes',
    run: (app) => app.store.dispatch((state) => changeLanesView(state, { folded: !state.lanesView.folded })),
  }),
  ...SUB_LANES.map(({ id, label, hint }) =>
    operation({
      id: `lane-${id}`,
      label: `Lane: ${label}`,
      keys: [],
      group: 'Lanes',
      tooltip: hint,
      run: (app) => app.store.dispatch(changeLanesView, { folded: true, lane: id }),
    }),
  ),
  operation({
    id: 'what-if',
    label: 'What if …',
    short: 'What if',
    keys: ['Shift+W'],
    icon: 'whatif',
    group: 'Engine',
    disabled: needsRun,
    tooltip: 'Replay the run with other parameters and see what would change (Shift+W)',
    run: (app) => app.store.dispatch((state) => openDialog(state, { kind: 'whatif', data: { run: state.review?.run?.id } })),
  }),
];

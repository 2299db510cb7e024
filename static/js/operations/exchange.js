// @ts-check
/** Export and import of annotations, recordings, bug bundles, and the views beside the picture. */

import { openDialog } from '../store/actions/page.js';
import { toggleBeside } from '../store/actions/review.js';
import { needsRun, operation } from './helpers.js';

/** @typedef {import('../state-types.js').State} State */
/** @typedef {import('../page-types.js').App} App */

const GROUP = 'Export, import, views';

/** @param {State} state @returns {string|null} */
function needsFrames(state) {
  return needsRun(state) ?? (state.review?.run && state.review.run.frames_done > 0 ? null : 'The run has stored no frames yet.');
}

/** The engine can replay only its own finished runs. @param {State} state @returns {string|null} */
function needsReplayable(state) {
  const missing = needsFrames(state);
  const run = state.review?.run;
  if (missing || !run) return missing;
  if (run.kind === 'imported') return 'This run was made by another program, so the engine cannot replay it.';
  return run.state === 'queued' || run.state === 'running' ? 'Wait until the run has ended.' : null;
}

/** @param {App} app @param {(review: import('../state-types.js').ReviewState) => import('../state-types.js').Dialog} dialog */
const show = (app, dialog) => app.store.dispatch((state) => (state.review ? openDialog(state, dialog(state.review)) : state));

/** @type {import('../page-types.js').Operation[]} */
export const exchange = [
  operation({
    id: 'export',
    label: 'Export annotations …',
    short: 'Export',
    keys: ['Shift+E'],
    icon: 'export',
    group: GROUP,
    disabled: (state) => needsRun(state) ?? (state.review?.run?.state === 'complete' ? null : 'Wait until the run is complete.'),
    run: (app) => show(app, ({ run }) => ({ kind: 'export', data: { runs: run ? [run.id] : [] } })),
  }),
  operation({
    id: 'import',
    label: 'Import annotations …',
    short: 'Import',
    keys: ['Shift+I'],
    icon: 'import',
    group: GROUP,
    run: (app) => show(app, ({ video }) => ({ kind: 'import', data: { video: video.id } })),
  }),
  operation({
    id: 'ground-truths',
    label: 'Ground truths …',
    short: 'Ground truth',
    keys: ['Shift+G'],
    icon: 'truth',
    group: GROUP,
    run: (app) => show(app, ({ video }) => ({ kind: 'ground-truths', data: { video: video.id } })),
  }),
  operation({
    id: 'record',
    label: 'Record frames …',
    short: 'Record',
    keys: ['Shift+R'],
    icon: 'record',
    group: GROUP,
    disabled: needsFrames,
    run: (app) => show(app, () => ({ kind: 'record' })),
  }),
  operation({
    id: 'report-bug',
    label: 'Report a bug …',
    short: 'Report a bug',
    keys: ['Shift+B'],
    icon: 'bug',
    group: GROUP,
    disabled: needsReplayable,
    run: (app) => show(app, () => ({ kind: 'bundle' })),
  }),
  operation({
    id: 'recording-view',
    label: 'Recording beside the picture',
    short: 'Recording',
    keys: ['Shift+V'],
    icon: 'film',
    group: GROUP,
    disabled: needsRun,
    run: (app) => app.store.dispatch(toggleBeside, 'recording'),
  }),
  operation({
    id: 'scene3d-view',
    label: '3-D view beside the picture',
    short: '3-D',
    keys: ['Shift+D'],
    icon: 'cube',
    group: GROUP,
    disabled: needsRun,
    run: (app) => app.store.dispatch(toggleBeside, 'scene3d'),
  }),
];
